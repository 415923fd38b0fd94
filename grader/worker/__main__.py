"""The worker's loop; see the package."""

from __future__ import annotations

import contextlib
import gc
import math
import os
import resource
import select
import signal
import socket
import sys
import time
from collections.abc import Callable
from typing import Any

from grader.worker.frames import DESCRIPTORS, EXITED, HEAD, Reader, frame
from grader.worker.lockdown import Filter, Lock
from grader.worker.session import StrayWrite, UnsetResult, WorkerSession
from grader.worker.shared import Shared
from grader.worker.syscalls import ARCHITECTURES

MAX_OUTPUT_BYTES = 1_000_000
MAX_DESCRIPTORS = 64
NOBODY = 65534
POLL_SECONDS = 0.002
ROUNDS = 20  # of ending what is left; an orphan's own children come in the next one
BURY_SECONDS = 0.05  # between looks at the sessions that are ending
LAST_WORD_SECONDS = 0.5  # to note where it is
# What the libraries of submissions need themselves: loaded once rather than in each session.
NEEDED = ("libm.so.6", "libgcc_s.so.1", "libubsan.so.1")

# What is done on a request: of its head, its payload and the descriptors that came with it.
_Act = Callable[[dict[str, Any], bytes, list[int]], bytes | None]


def _serve(
    sock: socket.socket, session: WorkerSession, shared: Shared, each: str, seconds: int
) -> None:
    """Answer the requests of one session, until it is closed.

    Each "call" in so many CPU seconds, or those from one "renew" to the next.
    """
    names = ("call", "get", "set", "buffer", "peek", "renew")
    acts = {name: getattr(session, name) for name in names}
    requests = Reader(sock)
    while True:
        head, payload = requests.frame()
        if head["do"] == "close":
            return
        if each in ("call", head["do"]):
            _limit_cpu(math.ceil(time.process_time()) + seconds)
        data: bytes | memoryview
        try:
            kind, data = "done", acts[head["do"]](head, shared.request(head, payload))
        except (StrayWrite, UnsetResult) as fault:
            kind, data = fault.kind, b""
        except MemoryError:
            kind, data = "memory", b""
        except Exception as error:  # whatever it is, the parent must hear of it and go on
            kind, data = "refused", str(error).encode()
        if head["do"] not in ("set", "renew") or kind != "done":
            sock.sendall(frame(*shared.reply(kind, data)))


def _limit(which: int, soft: int, hard: int) -> None:
    # A system may refuse a limit that another grants (macOS and RLIMIT_AS): the deadline remains.
    with contextlib.suppress(ValueError, OSError):
        resource.setrlimit(which, (soft, hard))


def _limit_cpu(seconds: int) -> None:
    """Bound the CPU seconds so that the bound can be moved."""
    _limit(resource.RLIMIT_CPU, seconds, resource.getrlimit(resource.RLIMIT_CPU)[1])


def _confine() -> None:
    """Bound the output and the open files of this process and of its children."""
    _limit(resource.RLIMIT_CORE, 0, 0)
    _limit(resource.RLIMIT_NOFILE, MAX_DESCRIPTORS, MAX_DESCRIPTORS)
    _limit(resource.RLIMIT_FSIZE, MAX_OUTPUT_BYTES, MAX_OUTPUT_BYTES)
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)


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
        self._filter: Filter | None = None
        self._libraries: dict[str, dict[str, Any]] = {}
        self._alive: dict[int, int] = {}  # the processes of sessions, by their numbers
        self._needed: list[Any] = []  # the libraries that stay loaded
        self._leaving: dict[int, float] = {}  # released, and until when each may take to end

    def run(self) -> None:
        """Serve requests until the parent is gone, then kill what is left."""
        acts: dict[str, _Act] = {"lock": self._shut_in, "library": self._library}
        acts |= {"fork": self._fork, "reap": self._reap, "release": self._release}
        self._control.sendall(frame({"is": "ready"}))
        try:
            while True:
                self._bury()
                patience = BURY_SECONDS if self._leaving else None
                if not select.select([self._control], [], [], patience)[0]:
                    continue
                start, descriptors, _, _ = socket.recv_fds(self._control, HEAD.size, DESCRIPTORS)
                if not start:
                    return
                head, payload = Reader(self._control, start, ahead=0).frame()
                answer = acts[head["do"]](head, payload, descriptors)
                if answer is not None:
                    self._control.sendall(frame({"is": "done"}, answer))
        finally:
            for session in list(self._alive):
                self._end(session)

    def _shut_in(self, head: dict[str, Any], payload: bytes, descriptors: list[int]) -> None:
        _confine()
        if os.geteuid() == 0:  # a submission never runs as root
            os.setgroups([])
            os.setresgid(NOBODY, NOBODY, NOBODY)
            os.setresuid(NOBODY, NOBODY, NOBODY)
        if sys.platform.startswith("linux"):
            Lock(_ffi(payload)).adopt_orphans()
        if head["machine"]:
            self._lock = Lock(_ffi(payload))
            self._filter = Filter(ARCHITECTURES[head["machine"]])
            self._lock.hide()
            self._lock.only_files(head["paths"])

    def _library(self, head: dict[str, Any], payload: bytes, descriptors: list[int]) -> None:
        ffi = _ffi(payload)
        for name in NEEDED[: None if head["sanitized"] else -1]:
            with contextlib.suppress(OSError):  # another system has others
                self._needed.append(ffi.dlopen(name))
        self._libraries[head["key"]] = {**head, "ffi": ffi}

    def _fork(self, head: dict[str, Any], payload: bytes, descriptors: list[int]) -> None:
        pid = os.fork()
        if pid == 0:
            status = 70
            try:
                self._child(head, self._libraries[head["key"]], descriptors)
                status = 0
            finally:
                os._exit(status)
        self._alive[head["session"]] = pid
        for each in descriptors:
            os.close(each)

    def _child(self, head: dict[str, Any], library: dict[str, Any], descriptors: list[int]) -> None:
        """Be the process of one session."""
        os.setsid()
        sock = socket.socket(fileno=descriptors[0])
        shared = Shared(descriptors[3])
        _keep(*descriptors[:3])
        if head["each"]:
            _limit_cpu(head["cpu"])
        else:
            _limit(resource.RLIMIT_CPU, head["cpu"], head["cpu"] + 1)
        if head["space"]:
            _limit(resource.RLIMIT_AS, head["space"], head["space"])
        if self._lock is not None and self._filter is not None:
            self._lock.hide()
            self._lock.filter_calls(self._filter)
        sock.sendall(frame({"is": "locked"}))
        try:
            session = WorkerSession(library["ffi"], library["path"], shared, library["sanitized"])
        except (OSError, library["ffi"].error) as error:
            sock.sendall(frame({"is": "unloadable"}, str(error).encode()))
            return
        can = bytes([session.keep()]) if head["each"] == "renew" else b""
        sock.sendall(frame({"is": "done"}, can))
        _serve(sock, session, shared, head["each"], head["cpu"])

    def _reap(self, head: dict[str, Any], payload: bytes, descriptors: list[int]) -> bytes:
        pid, grace = self._alive[head["session"]], head["grace"]
        if head["ask"]:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGUSR1)
            grace += LAST_WORD_SECONDS
        _wait(pid, grace)
        return self._end(head["session"])

    def _release(self, head: dict[str, Any], payload: bytes, descriptors: list[int]) -> None:
        self._leaving[head["session"]] = time.monotonic() + head["grace"]

    def _bury(self) -> None:
        """End the released sessions that are over, or late."""
        for session, deadline in list(self._leaving.items()):
            if _is_over(self._alive[session]) or time.monotonic() > deadline:
                del self._leaving[session]
                self._end(session)

    def _end(self, session: int) -> bytes:
        pid = self._alive.pop(session)
        by_itself = _is_over(pid)  # or by somebody else
        _kill(pid)  # itself, and what the code may have started in its session
        _, status, usage = os.wait4(pid, 0)
        self._sweep()
        return EXITED.pack(status if by_itself else 0, usage.ru_utime + usage.ru_stime)

    def _sweep(self) -> None:
        """End what sessions have left, where nothing keeps their code from starting processes."""
        for _ in range(ROUNDS):
            left = _children() - set(self._alive.values())
            if not left:
                return
            for pid in left:
                _kill(pid)
                os.waitpid(pid, 0)


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


def _children() -> set[int]:
    """Return this process's children; none where there is no /proc, as in a sandbox."""
    pid = os.getpid()
    try:
        with open(f"/proc/{pid}/task/{pid}/children", encoding="ascii") as file:
            return set(map(int, file.read().split()))
    except OSError:
        return set()


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
