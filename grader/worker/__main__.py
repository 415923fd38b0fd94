"""The worker's loop; see the package."""

from __future__ import annotations

import contextlib
import gc
import mmap
import os
import resource
import select
import signal
import socket
import struct
import sys
import time
from typing import Any

from grader.worker.frames import DESCRIPTORS, EXITED, HEAD, PAGE_BYTES, read_frame, write_frame
from grader.worker.lockdown import Lock
from grader.worker.session import Session, StrayWrite
from grader.worker.syscalls import ARCHITECTURES, Architecture

MAX_OUTPUT_BYTES = 1_000_000
MAX_DESCRIPTORS = 64
NOBODY = 65534
POLL_SECONDS = 0.002
BURY_SECONDS = 0.05  # between looks at the sessions that are ending
LAST_WORD_SECONDS = 0.5  # to note where it is


def _serve(sock: socket.socket, session: Session) -> None:
    """Answer the requests of one session, until it is closed."""
    acts = {name: getattr(session, name) for name in ("call", "get", "set", "buffer", "peek")}
    while True:
        head, payload = read_frame(sock)
        if head["do"] == "close":
            return
        try:
            kind, data = "done", acts[head["do"]](head, payload)
        except StrayWrite:
            kind, data = "stray", b""
        except MemoryError:
            kind, data = "memory", b""
        except Exception as error:  # whatever it is, the parent must hear of it and go on
            kind, data = "refused", str(error).encode()
        write_frame(sock, {"is": kind}, data)


def _limit(which: int, soft: int, hard: int) -> None:
    # A system may refuse a limit that another grants (macOS and RLIMIT_AS): the deadline remains.
    with contextlib.suppress(ValueError, OSError):
        resource.setrlimit(which, (soft, hard))


def _confine(cpu: int, space: int) -> None:
    """Bound the CPU seconds, the bytes of addresses, the output and the open files."""
    _limit(resource.RLIMIT_CPU, cpu, cpu + 1)
    _limit(resource.RLIMIT_CORE, 0, 0)
    _limit(resource.RLIMIT_NOFILE, MAX_DESCRIPTORS, MAX_DESCRIPTORS)
    _limit(resource.RLIMIT_FSIZE, MAX_OUTPUT_BYTES, MAX_OUTPUT_BYTES)
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    if space:
        _limit(resource.RLIMIT_AS, space, space)


def _keep(sock: int, output: int, errors: int) -> None:
    """Close every descriptor but the session's socket, stdin (/dev/null) and the two outputs."""
    os.dup2(output, 1)
    os.dup2(errors, 2)
    last = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    os.closerange(3, sock)
    os.closerange(sock + 1, last)


class Worker:
    """The worker's loop: it forks children and buries them, and never runs a submission's code."""

    def __init__(self, control: socket.socket) -> None:
        self._control = control
        self._lock: Lock | None = None
        self._architecture: Architecture | None = None
        self._libraries: dict[str, dict[str, Any]] = {}
        self._alive: set[int] = set()
        self._leaving: dict[int, float] = {}  # released, and until when each may take to end

    def run(self) -> None:
        """Serve requests until the parent is gone, then kill what is left."""
        acts = {"lock": self._shut_in, "library": self._library}
        acts |= {"fork": self._fork, "reap": self._reap, "release": self._release}
        write_frame(self._control, {"is": "ready"})
        try:
            while True:
                self._bury()
                patience = BURY_SECONDS if self._leaving else None
                if not select.select([self._control], [], [], patience)[0]:
                    continue
                start, descriptors, _, _ = socket.recv_fds(self._control, HEAD.size, DESCRIPTORS)
                if not start:
                    return
                head, payload = read_frame(self._control, start=start)
                answer = acts[head["do"]](head, payload, descriptors)
                write_frame(self._control, {"is": "done"}, answer)
        finally:
            for pid in self._alive:
                _kill(pid)

    def _shut_in(self, head: dict[str, Any], payload: bytes, descriptors: list[int]) -> bytes:
        if os.geteuid() == 0:  # a submission never runs as root
            os.setgroups([])
            os.setresgid(NOBODY, NOBODY, NOBODY)
            os.setresuid(NOBODY, NOBODY, NOBODY)
        if head["machine"]:
            self._lock = Lock(_ffi(payload))
            self._architecture = ARCHITECTURES[head["machine"]]
            self._lock.hide()
            self._lock.only_files(head["paths"])
        return b""

    def _library(self, head: dict[str, Any], payload: bytes, descriptors: list[int]) -> bytes:
        self._libraries[head["key"]] = {**head, "ffi": _ffi(payload)}
        return b""

    def _fork(self, head: dict[str, Any], payload: bytes, descriptors: list[int]) -> bytes:
        pid = os.fork()
        if pid == 0:
            status = 70
            try:
                self._child(head, self._libraries[head["key"]], descriptors)
                status = 0
            finally:
                os._exit(status)
        self._alive.add(pid)
        for each in descriptors:
            os.close(each)
        return struct.pack("=q", pid)

    def _child(self, head: dict[str, Any], library: dict[str, Any], descriptors: list[int]) -> None:
        """Be the process of one session."""
        os.setsid()
        sock = socket.socket(fileno=descriptors[0])
        page = mmap.mmap(descriptors[3], PAGE_BYTES)
        _keep(*descriptors[:3])
        _confine(head["cpu"], head["space"])
        if self._lock is not None and self._architecture is not None:
            self._lock.hide()
            self._lock.filter_calls(self._architecture)
        write_frame(sock, {"is": "locked"})
        try:
            session = Session(library["ffi"], library["path"], page, library["sanitized"])
        except (OSError, library["ffi"].error) as error:
            write_frame(sock, {"is": "unloadable"}, str(error).encode())
            return
        write_frame(sock, {"is": "done"})
        _serve(sock, session)

    def _reap(self, head: dict[str, Any], payload: bytes, descriptors: list[int]) -> bytes:
        pid, grace = head["pid"], head["grace"]
        if head["ask"]:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGUSR1)
            grace += LAST_WORD_SECONDS
        _wait(pid, grace)
        return self._end(pid)

    def _release(self, head: dict[str, Any], payload: bytes, descriptors: list[int]) -> bytes:
        self._leaving[head["pid"]] = time.monotonic() + head["grace"]
        return b""

    def _bury(self) -> None:
        """End the released sessions that are over, or late."""
        for pid, deadline in list(self._leaving.items()):
            if _is_over(pid) or time.monotonic() > deadline:
                del self._leaving[pid]
                self._end(pid)

    def _end(self, pid: int) -> bytes:
        _kill(pid)  # itself, and what the code may have started in its session
        _, status, usage = os.wait4(pid, 0)
        self._alive.discard(pid)
        return EXITED.pack(status, usage.ru_utime + usage.ru_stime)


def _ffi(code: bytes) -> Any:
    """Return the `ffi` that cffi's generated code makes; the code is the grader's own."""
    names: dict[str, Any] = {}
    exec(code, names)
    return names["ffi"]


def _wait(pid: int, seconds: float) -> None:
    """Wait until a child has ended, or for that time."""
    if hasattr(os, "pidfd_open"):
        descriptor = os.pidfd_open(pid)
        select.select([descriptor], [], [], seconds)
        os.close(descriptor)
        return
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        if _is_over(pid):
            return
        time.sleep(POLL_SECONDS)


def _is_over(pid: int) -> bool:
    return os.waitid(os.P_PID, pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None


def _kill(pid: int) -> None:
    for kill in (os.kill, os.killpg):
        with contextlib.suppress(ProcessLookupError, PermissionError):
            kill(pid, signal.SIGKILL)


def main() -> None:
    """Serve on the descriptor that the command line gives."""
    gc.disable()  # nothing to collect; and a collection would copy the pages shared with children
    Worker(socket.socket(fileno=int(sys.argv[1]))).run()


if __name__ == "__main__":
    main()
