"""What a session's process gives up before it loads a submission's code. Linux only.

Nothing here can be undone by the process, nor by what it starts.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator, Sequence
from typing import Any

from grader.worker.syscalls import Architecture

LIBC = """
int prctl(int option, unsigned long a, unsigned long b, unsigned long c, unsigned long d);
long syscall(long number, long a, long b, long c, long d);
"""

_SET_PDEATHSIG, _SET_DUMPABLE, _SET_SECCOMP, _SET_CHILD_SUBREAPER = 1, 4, 22, 36
_SET_NO_NEW_PRIVS = 38
_SECCOMP_MODE_FILTER = 2

# Instructions of the kernel's packet filter, and what a filter may answer.
_LOAD, _EQUAL, _ANY_BIT, _RETURN = 0x20, 0x15, 0x45, 0x06
_ALLOW, _KILL, _ERRNO = 0x7FFF0000, 0x80000000, 0x00050000
_EACCES, _EPERM, _ENOSYS = 13, 1, 38
_NUMBER, _ARCHITECTURE, _ARGUMENT = 0, 4, 16  # offsets in the data that a filter sees
_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC

_LANDLOCK_CREATE, _LANDLOCK_ADD, _LANDLOCK_RESTRICT = 444, 445, 446
_LANDLOCK_VERSION_QUESTION, _LANDLOCK_BENEATH = 1, 1
_READ_FILE, _LIST_FOLDER = 0b101, 0b1000  # the first with running it
# How many kinds of access each version of Landlock knows; later ones add none to files' opening.
_LANDLOCK_KINDS = {1: 13, 2: 14}
_LANDLOCK_KINDS_NOW = 15


class LockError(Exception):
    """The kernel does not lock the process: nothing of a submission may run in it."""


class Lock:
    """The kernel's locks, reached through the C library."""

    def __init__(self, ffi: Any) -> None:
        self._ffi, self._libc = ffi, ffi.dlopen(None)

    def hide(self) -> None:
        """Be no longer open to debuggers, nor able to gain privileges; die with the parent."""
        self.close_to_debuggers()
        self._prctl(_SET_NO_NEW_PRIVS, 1)
        self._prctl(_SET_PDEATHSIG, 9)

    def close_to_debuggers(self) -> None:
        """Let nobody of the same user attach to this process, nor read its memory."""
        self._prctl(_SET_DUMPABLE, 0)

    def adopt_orphans(self) -> None:
        """Become the parent of what children leave behind when they end."""
        self._prctl(_SET_CHILD_SUBREAPER, 1)

    def only_files(self, read: Sequence[str], write: Sequence[str] = ()) -> bool:
        """Leave nothing of the files but reading, or writing, in these places.

        Programs in places that can be read can be run. Returns False on a kernel without Landlock.
        """
        version = self._libc.syscall(_LANDLOCK_CREATE, 0, 0, _LANDLOCK_VERSION_QUESTION, 0)
        if version < 1:
            return False
        kinds = (1 << _LANDLOCK_KINDS.get(version, _LANDLOCK_KINDS_NOW)) - 1
        rules = self._call(_LANDLOCK_CREATE, struct.pack("=Q", kinds), 8)
        for path in read:
            self._rule(rules, path, _READ_FILE)
        for path in write:
            self._rule(rules, path, kinds)
        if self._libc.syscall(_LANDLOCK_RESTRICT, rules, 0, 0, 0) != 0:
            raise LockError("Landlock")
        os.close(rules)
        return True

    def filter_calls(self, calls: Filter) -> None:
        """Refuse every system call but those of the list, for ever."""
        program = calls.of(os.getpid())
        code = self._ffi.from_buffer(program)
        address = int(self._ffi.cast("uintptr_t", code))
        # struct sock_fprog: the number of instructions, and where they are.
        header = self._ffi.from_buffer(struct.pack("@HP", len(program) // 8, address))
        pointer = int(self._ffi.cast("uintptr_t", header))
        self._prctl(_SET_SECCOMP, _SECCOMP_MODE_FILTER, pointer)

    def _prctl(self, option: int, a: int, b: int = 0) -> None:
        if self._libc.prctl(option, a, b, 0, 0) != 0:
            raise LockError(f"prctl {option}")

    def _call(self, number: int, data: bytes, *rest: int) -> int:
        held = self._ffi.from_buffer(data)
        address = int(self._ffi.cast("uintptr_t", held))
        answer = int(self._libc.syscall(number, address, *rest, *[0] * (3 - len(rest))))
        if answer < 0:
            raise LockError(f"system call {number}")
        return answer

    def _rule(self, rules: int, path: str, kinds: int) -> None:
        try:
            place = os.open(path, os.O_PATH | os.O_CLOEXEC)
        except FileNotFoundError:
            return
        if os.path.isdir(path):
            kinds |= _LIST_FOLDER
        held = self._ffi.from_buffer(struct.pack("=Qi", kinds, place))
        address = int(self._ffi.cast("uintptr_t", held))
        if self._libc.syscall(_LANDLOCK_ADD, rules, _LANDLOCK_BENEATH, address, 0) != 0:
            raise LockError(f"Landlock: {path}")
        os.close(place)


class Filter:
    """The instructions that filter system calls, but for what depends on the process.

    They run one after another; each test skips the next few when it fails.
    """

    def __init__(self, architecture: Architecture) -> None:
        self._to_itself = architecture.to_itself.values()
        self._before = b"".join(_recognise(architecture))
        self._after = _step(_RETURN, _ERRNO | _ENOSYS)

    def of(self, process: int) -> bytes:
        """Return the filter of a process, which may send signals to itself only."""
        own = [
            step
            for number in self._to_itself
            for step in _when(number, 0, _EQUAL, process, _ALLOW, _ERRNO | _EPERM)
        ]
        return b"".join((self._before, *own, self._after))


def _recognise(architecture: Architecture) -> Iterator[bytes]:
    yield _step(_LOAD, _ARCHITECTURE)
    yield _step(_EQUAL, architecture.audit, if_true=1)
    yield _step(_RETURN, _KILL)
    yield _step(_LOAD, _NUMBER)
    for number in architecture.allowed.values():
        yield _step(_EQUAL, number, if_false=1)
        yield _step(_RETURN, _ALLOW)
    for number, flags in architecture.opens.values():
        yield from _when(number, flags, _ANY_BIT, _WRITING, _ERRNO | _EACCES, _ALLOW)
    for number in architecture.limits.values():
        yield from _when(number, 0, _EQUAL, 0, _ALLOW, _ERRNO | _EPERM)


def _when(
    number: int, argument: int, test: int, value: int, then: int, otherwise: int
) -> Iterator[bytes]:
    """Yield the steps that answer one system call by the low half of one of its arguments."""
    yield _step(_EQUAL, number, if_false=4)
    yield _step(_LOAD, _ARGUMENT + 8 * argument)
    yield _step(test, value, if_false=1)
    yield _step(_RETURN, then)
    yield _step(_RETURN, otherwise)


def _step(code: int, value: int, if_true: int = 0, if_false: int = 0) -> bytes:
    return struct.pack("=HBBI", code, if_true, if_false, value)
