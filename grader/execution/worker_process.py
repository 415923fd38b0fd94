"""The parent's side of a worker: starting it, shut in, and having it start sessions.

Requests are sent without waiting, so that a worker starts, and a session for the next check is made
ready, while something else goes on here. What has failed is heard when an answer is due; every wait
has a deadline, and everything that comes back is checked for its length.
"""

from __future__ import annotations

import contextlib
import fcntl
import itertools
import math
import mmap
import os
import platform
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import IO, Any

from grader.execution.control_socket import ControlSocket
from grader.execution.memory_watch import MemoryWatch
from grader.execution.records import Cause, Death, Limits
from grader.execution.session_socket import (
    ANSWER_SECONDS,
    Died,
    MachineError,
    Missing,
    NotLocked,
    Overdrawn,
    SessionSocket,
)
from grader.sandbox import bubblewrap
from grader.sandbox.budget import SECONDS, Budget
from grader.sandbox.ffi_source import library_source
from grader.sandbox.levels import Isolation, Level, current
from grader.sandbox.staging import private_folder, stage
from grader.sandbox.surroundings import LOCALE
from grader.sandbox.tools import finish
from grader.worker import frames

# With what callers need of session_socket.py.
__all__ = [
    "Died",
    "Limits",
    "MachineError",
    "Missing",
    "Overdrawn",
    "SessionSocket",
    "WorkerProcess",
    "start_worker",
]

INSIDE_STAGE, INSIDE_INBOX = "/mrt/stage", "/mrt/inbox"  # in a sandbox
SANITIZER_OPTIONS = {
    # Leaks are no mistake here; a report ends in SIGABRT; too large a malloc gives NULL, as it
    # should.
    # Addresses are turned into lines out here, where there is a /proc.
    "ASAN_OPTIONS": "detect_leaks=0:abort_on_error=1:allocator_may_return_null=1"
    # Memory that nobody has written holds no zeros: who counts on them is wrong.
    ":max_malloc_fill_size=1048576"
    # Files that define a global twice are judged all the same.
    ":detect_odr_violation=0:symbolize=0:handle_abort=0",
    "UBSAN_OPTIONS": "abort_on_error=1:symbolize=0",
}

_Kind = tuple[str, Limits]  # of sessions: the library, and its limits


@contextlib.contextmanager
def start_worker(preload: str = "", budget: Budget | None = None) -> Iterator[WorkerProcess]:
    """Start a worker, with libraries loaded before everything else; end it with the block.

    It is as isolated as `sandbox.levels.current()` says. Returns before the worker is there; that
    it does not start is told by its first session. It lives no longer than the thread that calls.
    `budget` is that of the submission; without one, each session's limits are all there is.
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
        control = ControlSocket(ours, errors)  # before the worker says who it is
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
            process = WorkerProcess(control, isolation, inbox, budget or Budget.endless())
            stack.callback(process.close)
            yield process
        finally:
            ours.close()  # the worker sees the end, and kills what is left before it goes
            finish(popen, ANSWER_SECONDS)


def _command(
    isolation: Isolation, inbox: Path, environment: Mapping[str, str], descriptor: int
) -> list[str]:
    # -S, -s: no site-packages; -B: no .pyc.
    python = [bubblewrap.interpreter(), "-S", "-s", "-B", "-m", "grader.worker", str(descriptor)]
    if isolation.level is not Level.STRONG:
        return python
    readable = [(str(stage()), INSIDE_STAGE), (str(inbox), INSIDE_INBOX)]
    # The sanitizers read their settings there rather than from the environment itself.
    settings = inbox.with_name("environ")
    settings.write_text("".join(f"{key}={environment[key]}\0" for key in environment))
    settings.chmod(0o644)
    readable.append((str(settings), "/proc/self/environ"))
    return bubblewrap.sandbox(readable, [], environment, python, INSIDE_STAGE)


def _environment(isolation: Isolation, preload: str) -> dict[str, str]:
    strong = isolation.level is Level.STRONG
    environment = {"PATH": "/usr/bin:/bin", **LOCALE}
    environment["PYTHONPATH"] = INSIDE_STAGE if strong else str(stage())
    if preload:
        name = "DYLD_INSERT_LIBRARIES" if sys.platform == "darwin" else "LD_PRELOAD"
        environment |= {name: preload, **SANITIZER_OPTIONS}
    return environment


class WorkerProcess:
    """The parent's hold on a worker. Made by start_worker."""

    def __init__(
        self, control: ControlSocket, isolation: Isolation, inbox: Path, budget: Budget
    ) -> None:
        self._control, self._isolation, self._inbox = control, isolation, inbox
        self._budget = budget
        self._watch: MemoryWatch | None = None
        self._numbers = itertools.count(1)
        self._spares: dict[_Kind, SessionSocket] = {}
        self._idle: dict[_Kind, SessionSocket] = {}  # that have served, and may again
        self._seen: set[_Kind] = set()
        self._choosing = threading.Lock()  # threads may start sessions at the same time
        machine = "" if isolation.level is Level.PORTABLE else platform.machine()
        strong = isolation.level is Level.STRONG
        paths = ["/"] if strong else [*bubblewrap.readable(), str(stage()), str(inbox)]
        control.tell({"do": "lock", "machine": machine, "paths": paths}, _lock_code())

    def declare(self, library: str, cdef: str, sanitized: bool) -> None:
        """Tell the worker of a library, by its path; it is loaded in the sessions only."""
        path = Path(library)
        shutil.copyfile(path, self._inbox / path.name)
        (self._inbox / path.name).chmod(0o644)
        strong = self._isolation.level is Level.STRONG
        inside = f"{INSIDE_INBOX if strong else self._inbox}/{path.name}"
        # Where it lies out here is nobody's business inside.
        head = {"do": "library", "key": path.name, "path": inside, "sanitized": sanitized}
        self._control.tell(head, library_source(cdef, library))

    @contextlib.contextmanager
    def fork(self, library: str, limits: Limits) -> Iterator[SessionSocket]:
        """Start a session with a declared library. Raises Died when it cannot be loaded.

        Once the submission's budget is spent, nothing is started any more.
        From the second of a kind on, one more is made ready meanwhile, for the next time.
        """
        kind = self._kind(library, limits)
        with self._choosing:
            channel = self._spares.pop(kind, None) or self._start(kind)
        try:
            with self._choosing:
                if kind in self._seen and kind not in self._spares:
                    self._spares[kind] = self._start(kind)
                self._seen.add(kind)
            self._begin(channel)
            yield channel
        finally:
            channel.close()

    @contextlib.contextmanager
    def lend(self, library: str, limits: Limits) -> Iterator[SessionSocket]:
        """Lend a session that may have served before, with all variables as they were first.

        Raises what fork does, and Overdrawn at the end when it took more than its seconds.
        """
        kind = self._kind(library, replace(limits, each_check=True))
        with self._choosing:
            served = self._idle.pop(kind, None)
            channel = served or self._start(kind)
        try:
            if served:
                served.renew()
            else:
                self._begin(channel)
            yield channel
            channel.settle()
        finally:
            with self._choosing:
                if channel.can_serve_on and kind not in self._idle:
                    self._idle[kind] = channel
                else:
                    channel.close()

    def close(self) -> None:
        """End the sessions that were made ready for nothing, and those that stayed."""
        for each in (*self._spares.values(), *self._idle.values()):
            each.close()
        if self._watch:
            self._watch.stop()

    def _kind(self, library: str, limits: Limits) -> _Kind:
        """Return the kind of session that may be started now. Raises Died when none may."""
        if spent := self._budget.spent:
            raise Died(Death(Cause.SPENT, spent, seconds=SECONDS[spent]))
        return library, replace(limits, cpu=limits.cpu * self._budget.share)

    def _begin(self, channel: SessionSocket) -> None:
        try:
            channel.begin()
        except NotLocked as error:
            raise self._control.failure("a session is not shut in", error) from error

    def _start(self, kind: _Kind) -> SessionSocket:
        library, limits = kind
        number, size = next(self._numbers), self._size()
        head: dict[str, Any] = {"do": "fork", "session": number, "key": Path(library).name}
        each = "call" if limits.each_call else "renew" if limits.each_check else ""
        head |= {"cpu": math.ceil(limits.cpu), "each": each}
        head["space"] = size + limits.memory + frames.SHARED_BYTES if size else 0
        ours, theirs = socket.socketpair()
        files = _files()
        reap, release = partial(self._reap, number), partial(self._release, number)
        if self._watch is None:
            more = limits.memory + frames.SHARED_BYTES
            self._watch = MemoryWatch(self._control.pid(), more)
            self._watch.start()
        channel = SessionSocket(
            reap, release, ours, files, limits, library, self._budget, self._watch
        )
        with theirs:
            self._control.tell(head, b"", [theirs.fileno(), *(each.fileno() for each in files)])
        return channel

    def _size(self) -> int:
        """Return how many bytes of addresses the worker has: the sanitizers' take terabytes."""
        try:
            statm = Path(f"/proc/{self._control.pid()}/statm").read_text(encoding="ascii")
        except OSError:
            return 0
        return int(statm.split()[0]) * mmap.PAGESIZE

    def _reap(self, session: int, grace: float, ask: bool) -> tuple[int, float]:
        head = {"do": "reap", "session": session, "grace": grace, "ask": ask}
        status, cpu = frames.EXITED.unpack(self._control.ask(head, frames.EXITED.size))
        return int(status), float(cpu)

    def _release(self, session: int, grace: float) -> None:
        self._control.tell({"do": "release", "session": session, "grace": grace})


def _files() -> list[IO[bytes]]:
    """Return a session's nameless files: two that are written at their end, and its memory."""
    output, errors, shared = (_file() for _ in range(3))
    for each in (output, errors):
        fcntl.fcntl(each, fcntl.F_SETFL, fcntl.fcntl(each, fcntl.F_GETFL) | os.O_APPEND)
    shared.truncate(frames.SHARED_BYTES)  # what is not used takes no room
    return [output, errors, shared]


def _file() -> IO[bytes]:
    if hasattr(os, "memfd_create"):
        return open(os.memfd_create("mrt"), "w+b", buffering=0)
    return tempfile.TemporaryFile(buffering=0)


@cache
def _lock_code() -> bytes:
    return (stage() / "lock_abi.py").read_bytes()
