"""The parent's side of a worker: starting it, shut in, and having it start sessions.

Every wait has a deadline; everything that comes back is checked for its length.
"""

from __future__ import annotations

import contextlib
import math
import mmap
import os
import platform
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from functools import cache, partial
from pathlib import Path
from typing import IO, Any

from grader.abi import abi_source
from grader.channel import (
    ANSWER_SECONDS,
    MAX_TEXT,
    Channel,
    Died,
    Limits,
    MachineError,
    Missing,
    printable,
)
from grader.isolation import bubble
from grader.isolation.levels import Isolation, Level, current
from grader.isolation.stage import private_folder, stage
from grader.worker import frames
from grader.worker.session import LIBC

# With what callers need of channel.py.
__all__ = ["Channel", "Died", "Limits", "MachineError", "Missing", "Process", "start_worker"]

INSIDE_STAGE, INSIDE_INBOX = "/mrt/stage", "/mrt/inbox"  # in a sandbox
SANITIZER_OPTIONS = {
    # Leaks are no mistake here; a report ends in SIGABRT; too large a malloc gives NULL, as it
    # should.
    # Addresses are turned into lines out here, where there is a /proc.
    "ASAN_OPTIONS": "detect_leaks=0:abort_on_error=1:allocator_may_return_null=1"
    # Files that define a global twice are judged all the same.
    ":detect_odr_violation=0:symbolize=0:handle_abort=0",
    "UBSAN_OPTIONS": "abort_on_error=1:symbolize=0",
}

_CREDENTIALS = struct.Struct("3i")  # process, user, group


@contextlib.contextmanager
def start_worker(preload: str = "") -> Iterator[Process]:
    """Start a worker, with libraries loaded before everything else; end it with the block.

    It is as isolated as `isolation.levels.current()` says.
    """
    isolation = current()
    folder = private_folder()
    inbox = folder / "inbox"
    inbox.mkdir(mode=0o755)
    ours, theirs = socket.socketpair()
    with contextlib.ExitStack() as stack:
        stack.callback(shutil.rmtree, folder, ignore_errors=True)
        stack.enter_context(ours)
        errors = stack.enter_context(tempfile.TemporaryFile())
        if hasattr(socket, "SO_PASSCRED"):
            ours.setsockopt(socket.SOL_SOCKET, socket.SO_PASSCRED, 1)
        environment = _environment(isolation, preload)
        with theirs:
            popen = subprocess.Popen(
                _command(isolation, inbox, environment, theirs.fileno()),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=errors,
                pass_fds=[theirs.fileno()],
                env=environment,
                start_new_session=True,
                cwd=stage(),
            )
        try:
            yield Process(ours, isolation, inbox, errors)
        finally:
            ours.close()  # the worker sees the end, and kills what is left before it goes
            try:
                popen.wait(timeout=ANSWER_SECONDS)
            except subprocess.TimeoutExpired:
                os.killpg(popen.pid, signal.SIGKILL)
                popen.wait()


def _command(
    isolation: Isolation, inbox: Path, environment: Mapping[str, str], descriptor: int
) -> list[str]:
    # -S, -s: no site-packages; -B: no .pyc.
    python = [bubble.interpreter(), "-S", "-s", "-B", "-m", "grader.worker", str(descriptor)]
    if isolation.level is not Level.STRONG:
        return python
    readable = [(str(stage()), INSIDE_STAGE), (str(inbox), INSIDE_INBOX)]
    # The sanitizers read their settings there rather than from the environment itself.
    settings = inbox.with_name("environ")
    settings.write_text("".join(f"{key}={environment[key]}\0" for key in environment))
    settings.chmod(0o644)
    readable.append((str(settings), "/proc/self/environ"))
    return bubble.sandbox(readable, [], environment, python, INSIDE_STAGE)


def _environment(isolation: Isolation, preload: str) -> dict[str, str]:
    strong = isolation.level is Level.STRONG
    environment = {"PATH": "/usr/bin:/bin", "LC_ALL": "C.UTF-8"}
    environment["PYTHONPATH"] = INSIDE_STAGE if strong else str(stage())
    if preload:
        name = "DYLD_INSERT_LIBRARIES" if sys.platform == "darwin" else "LD_PRELOAD"
        environment |= {name: preload, **SANITIZER_OPTIONS}
    return environment


class Process:
    """The parent's hold on a worker. Made by start_worker."""

    def __init__(
        self, control: socket.socket, isolation: Isolation, inbox: Path, errors: IO[bytes]
    ) -> None:
        self._control, self._isolation = control, isolation
        self._inbox, self._errors = inbox, errors
        self._pid = 0  # of the worker, as seen from here; 0 when this system does not tell

    def declare(self, library: str, cdef: str, sanitized: bool) -> None:
        """Tell the worker of a library, by its path; it is loaded in the sessions only."""
        if not self._pid:
            self._greet()
        path = Path(library)
        shutil.copyfile(path, self._inbox / path.name)
        (self._inbox / path.name).chmod(0o644)
        strong = self._isolation.level is Level.STRONG
        inside = f"{INSIDE_INBOX if strong else self._inbox}/{path.name}"
        head = {"do": "library", "key": library, "path": inside, "sanitized": sanitized}
        self._ask(head, 0, abi_source(cdef + LIBC, path.parent.parent / "bindings"))

    def _greet(self) -> None:
        """Wait for the worker, and have it shut itself in."""
        try:
            self._control.settimeout(ANSWER_SECONDS)
            self._pid = _sender(self._control)
            frames.read_frame(self._control, 0, time.monotonic() + ANSWER_SECONDS)
        except (OSError, EOFError, ValueError) as error:
            raise self._failure("it does not start", error) from error
        portable = self._isolation.level is Level.PORTABLE
        machine = "" if portable else platform.machine()
        strong = self._isolation.level is Level.STRONG
        paths = ["/"] if strong else [*bubble.readable(), str(stage()), str(self._inbox)]
        self._ask({"do": "lock", "machine": machine, "paths": paths}, 0, _lock_code())

    @contextlib.contextmanager
    def fork(self, library: str, limits: Limits) -> Iterator[Channel]:
        """Start a session with a declared library. Raises Died when it cannot be loaded."""
        ours, theirs = socket.socketpair()
        with contextlib.ExitStack() as stack:
            files = [stack.enter_context(tempfile.TemporaryFile()) for _ in range(3)]
            stack.enter_context(ours)
            files[2].truncate(frames.PAGE_BYTES)
            space = self._size() + limits.memory if self._size() else 0
            head = {"do": "fork", "key": library, "cpu": math.ceil(limits.cpu), "space": space}
            with theirs:
                descriptors = [theirs.fileno(), *(each.fileno() for each in files)]
                pid = self._ask(head, 8, descriptors=descriptors)
            number = int.from_bytes(pid, sys.byteorder)
            reap, release = partial(self._reap, number), partial(self._release, number)
            channel = Channel(reap, release, ours, files, limits, library)
            try:
                channel.begin()
                yield channel
            finally:
                channel.close()

    def _size(self) -> int:
        """Return how many bytes of addresses the worker has: the sanitizers' take terabytes."""
        try:
            statm = Path(f"/proc/{self._pid}/statm").read_text(encoding="ascii")
        except OSError:
            return 0
        return int(statm.split()[0]) * mmap.PAGESIZE

    def _reap(self, pid: int, grace: float, ask: bool) -> tuple[int, float]:
        head = {"do": "reap", "pid": pid, "grace": grace, "ask": ask}
        status, cpu = frames.EXITED.unpack(self._ask(head, frames.EXITED.size))
        return int(status), float(cpu)

    def _release(self, pid: int, grace: float) -> None:
        self._ask({"do": "release", "pid": pid, "grace": grace}, 0)

    def _ask(
        self,
        head: dict[str, Any],
        size: int,
        payload: bytes = b"",
        descriptors: list[int] | None = None,
    ) -> bytes:
        deadline = time.monotonic() + ANSWER_SECONDS
        try:
            self._control.settimeout(ANSWER_SECONDS)
            frames.write_frame(self._control, head, payload, descriptors or [])
            _, answer = frames.read_frame(self._control, size, deadline)
        except (OSError, EOFError, ValueError) as error:
            raise self._failure(f"it does not answer ({head['do']})", error) from error
        if len(answer) != size:
            raise MachineError(f"the worker's answer to {head['do']} has {len(answer)} bytes")
        return answer

    def _failure(self, what: str, error: Exception) -> MachineError:
        said = os.pread(self._errors.fileno(), MAX_TEXT, 0).decode(errors="replace")
        last = printable(said).strip().splitlines()[-1:] or [repr(error)]
        return MachineError(f"the worker failed, {what}: {last[0]}")


def _sender(control: socket.socket) -> int:
    """Return the number of the process at the other end, once it has written; 0 if unknown."""
    if not hasattr(socket, "SCM_CREDENTIALS"):
        return 0
    room = socket.CMSG_SPACE(_CREDENTIALS.size)
    _, ancillary, _, _ = control.recvmsg(1, room, socket.MSG_PEEK)
    for level, kind, data in ancillary:
        if (level, kind) == (socket.SOL_SOCKET, socket.SCM_CREDENTIALS):
            return int(_CREDENTIALS.unpack(data[: _CREDENTIALS.size])[0])
    return 0


@cache
def _lock_code() -> bytes:
    return (stage() / "lock_abi.py").read_bytes()
