"""The worker's loop; see the package."""

from __future__ import annotations

import contextlib
import mmap
import os
import resource
import signal
import socket
import struct
import sys
import time
from typing import Any

import cffi

from grader.worker.frames import DESCRIPTORS, EXITED, HEAD, PAGE_BYTES, read_frame, write_frame
from grader.worker.session import LIBC, Session, StrayWrite

MAX_OUTPUT_BYTES = 1_000_000
POLL_SECONDS = 0.002


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
        except Exception as error:  # whatever it is, the parent must hear of it and go on
            kind, data = "refused", str(error).encode()
        write_frame(sock, {"is": kind}, data)


def _limit(which: int, soft: int, hard: int) -> None:
    # A system may refuse a limit that another grants (macOS and RLIMIT_AS): the deadline remains.
    with contextlib.suppress(ValueError, OSError):
        resource.setrlimit(which, (soft, hard))


def _confine(cpu: int, memory: int) -> None:
    """Bound the CPU seconds, the bytes of memory beyond those in use now, and the output."""
    _limit(resource.RLIMIT_CPU, cpu, cpu + 1)
    _limit(resource.RLIMIT_CORE, 0, 0)
    _limit(resource.RLIMIT_FSIZE, MAX_OUTPUT_BYTES, MAX_OUTPUT_BYTES)
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    with contextlib.suppress(OSError), open("/proc/self/statm", encoding="ascii") as statm:
        size = int(statm.read().split()[0]) * mmap.PAGESIZE + memory
        _limit(resource.RLIMIT_AS, size, size)


def _child(head: dict[str, Any], library: dict[str, Any], descriptors: list[int]) -> None:
    """Be the process of one session."""
    os.setsid()
    sock = socket.socket(fileno=descriptors[0])
    os.dup2(descriptors[1], 1)
    os.dup2(descriptors[2], 2)
    page = mmap.mmap(descriptors[3], PAGE_BYTES)
    for each in descriptors[1:]:
        os.close(each)
    _confine(head["cpu"], head["memory"])
    try:
        session = Session(library["ffi"], library["path"], page, not library["sanitized"])
    except (OSError, AttributeError) as error:
        write_frame(sock, {"is": "unloadable"}, str(error).encode())
        return
    write_frame(sock, {"is": "done"})
    _serve(sock, session)


class Worker:
    """The worker's loop: it forks children and buries them, and never runs a submission's code."""

    def __init__(self, control: socket.socket) -> None:
        self._control = control
        self._libraries: dict[str, dict[str, Any]] = {}
        self._alive: set[int] = set()

    def run(self) -> None:
        """Serve requests until the parent is gone, then kill what is left."""
        try:
            while True:
                start, descriptors, _, _ = socket.recv_fds(self._control, HEAD.size, DESCRIPTORS)
                if not start:
                    return
                head, payload = read_frame(self._control, start=start)
                act = {"library": self._library, "fork": self._fork, "reap": self._reap}[head["do"]]
                write_frame(self._control, {"is": "done"}, act(head, payload, descriptors))
        finally:
            for pid in self._alive:
                _kill(pid)

    def _library(self, head: dict[str, Any], payload: bytes, descriptors: list[int]) -> bytes:
        ffi = cffi.FFI()
        ffi.cdef(payload.decode() + LIBC)
        self._libraries[head["key"]] = {**head, "ffi": ffi}
        return b""

    def _fork(self, head: dict[str, Any], payload: bytes, descriptors: list[int]) -> bytes:
        pid = os.fork()
        if pid == 0:
            status = 70
            try:
                self._control.close()
                _child(head, self._libraries[head["key"]], descriptors)
                status = 0
            finally:
                os._exit(status)
        self._alive.add(pid)
        for each in descriptors:
            os.close(each)
        return struct.pack("=q", pid)

    def _reap(self, head: dict[str, Any], payload: bytes, descriptors: list[int]) -> bytes:
        pid, deadline = head["pid"], time.monotonic() + head["grace"]
        while True:
            gone, status, usage = os.wait4(pid, os.WNOHANG)
            if gone:
                break
            if time.monotonic() > deadline:
                _kill(pid)
            time.sleep(POLL_SECONDS)
        _kill(pid)  # what the code may have started in its session
        self._alive.discard(pid)
        return EXITED.pack(status, usage.ru_utime + usage.ru_stime)


def _kill(pid: int) -> None:
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(pid, signal.SIGKILL)


def main() -> None:
    """Serve on the descriptor that the command line gives."""
    os.chdir("/")
    Worker(socket.socket(fileno=int(sys.argv[1]))).run()


if __name__ == "__main__":
    main()
