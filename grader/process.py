"""The parent's side of a worker: starting it, talking to it, and saying how it ended.

Every wait has a deadline; everything that comes back is checked for its length.
"""

from __future__ import annotations

import contextlib
import math
import mmap
import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import cffi

from grader.manifest import ROOT
from grader.records import Cause, Death
from grader.worker import frames

ANSWER_SECONDS = 20  # for the worker itself, which runs no code but ours
GRACE_SECONDS = 1  # between the end of a session's socket and the end of its process
MAX_TEXT = 20_000  # characters of output that are kept
SANITIZER_OPTIONS = {
    # Leaks are no mistake here; a report ends in SIGABRT; too large a malloc gives NULL, as it
    # should.
    "ASAN_OPTIONS": "detect_leaks=0:abort_on_error=1:allocator_may_return_null=1",
    "UBSAN_OPTIONS": "abort_on_error=1",
    "PYTHONMALLOC": "malloc",
}

_SANITIZER = re.compile(r"ERROR: AddressSanitizer:? ([\w-]+)|(?:\S+): runtime error: (.*)")
_FRAME = re.compile(r"^\s*#\d+ 0x[0-9a-f]+ in .*?(?:^|[\s/])([\w.]+\.[ch]):(\d+)", re.MULTILINE)
_RUNTIME_ERROR = re.compile(r"^(?:\./)?([\w.]+\.[ch]):(\d+):\d+: runtime error", re.MULTILINE)


class MachineError(Exception):
    """The worker failed without running the submission: the grader's or the machine's fault."""


class Died(Exception):
    """The process that ran the submission is gone; `death` says how."""

    def __init__(self, death: Death) -> None:
        super().__init__(f"{death.cause.value} {death.word} {death.location}".strip())
        self.death = death


class Missing(Exception):
    """The submission lacks this function or global variable."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.name = name


@dataclass(frozen=True)
class Limits:
    """Bounds of one session: CPU seconds, and bytes of memory beyond what the worker uses."""

    cpu: float = 10.0
    memory: int = 512 << 20

    @property
    def wall(self) -> float:
        """Seconds of waiting for one answer: generous, a loaded machine is not the code's fault."""
        return 3 * self.cpu + 2


@contextlib.contextmanager
def start_worker(preload: str = "") -> Iterator[Process]:
    """Start a worker, with a library loaded before everything else; end it with the block."""
    ours, theirs = socket.socketpair()
    with ours:
        # -S, -s: no site-packages, cffi comes by its folder alone; -B: no .pyc.
        command = [sys.executable, "-S", "-s", "-B", "-m", "grader.worker", str(theirs.fileno())]
        with theirs:
            popen = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                pass_fds=[theirs.fileno()],
                env=_environment(preload),
                start_new_session=True,
                cwd=ROOT,
            )
        try:
            yield Process(ours)
        finally:
            ours.close()  # the worker sees the end, and kills what is left before it goes
            try:
                popen.wait(timeout=ANSWER_SECONDS)
            except subprocess.TimeoutExpired:
                popen.kill()
                popen.wait()


def _environment(preload: str) -> dict[str, str]:
    site = str(Path(cffi.__file__).resolve().parent.parent)
    environment = {"PATH": "/usr/bin:/bin", "LC_ALL": "C.UTF-8", "PYTHONPATH": site}
    if preload:
        name = "DYLD_INSERT_LIBRARIES" if sys.platform == "darwin" else "LD_PRELOAD"
        environment |= {name: preload, **SANITIZER_OPTIONS}
    return environment


class Process:
    """The parent's hold on a worker. Made by start_worker."""

    def __init__(self, control: socket.socket) -> None:
        self._control = control

    def declare(self, library: str, cdef: str, sanitized: bool) -> None:
        """Tell the worker of a library, by its path; it is loaded in the sessions only."""
        head = {"do": "library", "key": library, "path": library, "sanitized": sanitized}
        self._ask(head, 0, cdef.encode())

    @contextlib.contextmanager
    def fork(self, library: str, limits: Limits) -> Iterator[Channel]:
        """Start a session with a declared library. Raises Died when it cannot be loaded."""
        ours, theirs = socket.socketpair()
        with contextlib.ExitStack() as stack:
            files = [stack.enter_context(tempfile.TemporaryFile()) for _ in range(3)]
            stack.enter_context(ours)
            files[2].truncate(frames.PAGE_BYTES)
            page = stack.enter_context(mmap.mmap(files[2].fileno(), frames.PAGE_BYTES))
            cpu = math.ceil(limits.cpu)
            head = {"do": "fork", "key": library, "cpu": cpu, "memory": limits.memory}
            with theirs:
                descriptors = [theirs.fileno(), *(each.fileno() for each in files)]
                pid = self._ask(head, 8, descriptors=descriptors)
            channel = Channel(self, int.from_bytes(pid, sys.byteorder), ours, page, files, limits)
            try:
                channel.hear(0)
                yield channel
            finally:
                channel.close()

    def reap(self, pid: int, grace: float) -> tuple[int, float]:
        """End a session's process after `grace` seconds; return its wait status and CPU seconds."""
        answer = self._ask({"do": "reap", "pid": pid, "grace": grace}, frames.EXITED.size)
        status, cpu = frames.EXITED.unpack(answer)
        return int(status), float(cpu)

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
            raise MachineError(f"the worker does not answer ({head['do']}): {error!r}") from error
        if len(answer) != size:
            raise MachineError(f"the worker's answer to {head['do']} has {len(answer)} bytes")
        return answer


class Channel:
    """The parent's side of one session."""

    def __init__(
        self,
        process: Process,
        pid: int,
        sock: socket.socket,
        page: mmap.mmap,
        files: Sequence[IO[bytes]],
        limits: Limits,
    ) -> None:
        self._process, self._pid, self._sock = process, pid, sock
        self._page, self._files, self._limits = page, files, limits
        self._ended = False

    def ask(self, head: dict[str, Any], size: int, payload: bytes = b"") -> bytes:
        """Send a request and return its answer of exactly `size` bytes.

        Raises Died, Missing, or ValueError when the request makes no sense.
        """
        if self._ended:
            raise ValueError("the session is over")
        try:
            self._sock.settimeout(self._limits.wall)
            frames.write_frame(self._sock, head, payload)
        except OSError:
            pass  # it has died: hearing says how
        return self.hear(size)

    def hear(self, size: int) -> bytes:
        """Wait for an answer of `size` bytes. Raises as `ask` does."""
        deadline = time.monotonic() + self._limits.wall
        try:
            head, answer = frames.read_frame(self._sock, max(size, MAX_TEXT), deadline)
        except TimeoutError:
            raise Died(self._bury(0, Cause.TIMEOUT)) from None
        except (OSError, EOFError, ValueError, RecursionError):
            raise Died(self._bury(GRACE_SECONDS, Cause.EXIT)) from None
        kind, text = head.get("is"), answer[:MAX_TEXT].decode(errors="replace")
        if kind == "done" and len(answer) == size:
            return answer
        if kind == "refused" and text.startswith("missing: "):
            raise Missing(text.removeprefix("missing: "))
        if kind == "refused":
            raise ValueError(text)
        causes = {"stray": Cause.STRAY_WRITE, "unloadable": Cause.LOAD}
        death = self._bury(0, causes.get(str(kind), Cause.EXIT))
        raise Died(Death(death.cause, case=death.case, text=text or death.text))

    def marks(self) -> bytes:
        """Return the page of MRT_TODO markers, one byte each, even after a crash."""
        return self._page[: frames.TODO_BYTES]

    def close(self) -> None:
        """End the session."""
        if self._ended:
            return
        self._ended = True
        with contextlib.suppress(OSError):
            self._sock.settimeout(GRACE_SECONDS)
            frames.write_frame(self._sock, {"do": "close"})
        self._process.reap(self._pid, GRACE_SECONDS)

    def _bury(self, grace: float, cause: Cause) -> Death:
        """End the process, and say why it died; `cause` when its end does not tell."""
        self._ended = True
        status, _ = self._process.reap(self._pid, grace)
        (case,) = frames.COUNTER.unpack_from(self._page, frames.TODO_BYTES)
        text = self._text()
        code = os.waitstatus_to_exitcode(status)
        if cause in (Cause.TIMEOUT, Cause.LOAD, Cause.STRAY_WRITE) or code == -signal.SIGXCPU:
            cause = Cause.TIMEOUT if code == -signal.SIGXCPU else cause
            return Death(cause, case=case, text=text)
        word = signal.Signals(-code).name if code < 0 else ""
        if code < 0 and (report := _SANITIZER.search(text)):
            word = report[1] or f"runtime error: {report[2]}"
        cause = Cause.SIGNAL if code < 0 else Cause.EXIT
        return Death(cause, word, max(code, 0), case, _location(text), text)

    def _text(self) -> str:
        """Return the beginning of what the code wrote on stderr, then stdout."""
        parts = []
        for each in (self._files[1], self._files[0]):
            each.seek(0)
            parts.append(each.read(MAX_TEXT).decode(errors="replace"))
        return "".join(parts)


def _location(report: str) -> str:
    """Return "file:line" of the first frame of a sanitizer's report that is C code of ours."""
    found = _RUNTIME_ERROR.search(report) or _FRAME.search(report)
    return f"{found[1]}:{found[2]}" if found else ""
