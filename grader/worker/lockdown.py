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

_SET_PDEATHSIG, _SET_DUMPABLE, _SET_SECCOMP, _SET_NO_NEW_PRIVS = 1, 4, 22, 38
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
        for option, value in ((_SET_DUMPABLE, 0), (_SET_NO_NEW_PRIVS, 1), (_SET_PDEATHSIG, 9)):
            self._prctl(option, value)

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

    def filter_calls(self, architecture: Architecture) -> None:
        """Refuse every system call but those of the list, for ever."""
        program = b"".join(_program(architecture, os.getpid()))
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


def _program(architecture: Architecture, process: int) -> Iterator[bytes]:
    """Yield the filter's instructions: one after another, each skips the next few when it fails."""
    yield _step(_LOAD, _ARCHITECTURE)
    yield _step(_EQUAL, architecture.audit, if_true=1)
    yield _step(_RETURN, _KILL)
    yield _step(_LOAD, _NUMBER)
    for number in architecture.allowed:
        yield _step(_EQUAL, number, if_false=1)
        yield _step(_RETURN, _ALLOW)
    for number, flags in architecture.opens:
        yield from _when(number, flags, _ANY_BIT, _WRITING, _ERRNO | _EACCES, _ALLOW)
    yield from _when(architecture.prlimit, 0, _EQUAL, 0, _ALLOW, _ERRNO | _EPERM)
    for number in architecture.to_itself:
        yield from _when(number, 0, _EQUAL, process, _ALLOW, _ERRNO | _EPERM)
    yield _step(_RETURN, _ERRNO | _ENOSYS)


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
