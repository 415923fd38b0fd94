"""The parent's side of a session: asking, hearing, and saying how its process ended.

Every wait has a deadline. Whatever comes back may be the submission's own work: it is checked for
its length, and is never more than a wrong answer or none.
"""

from __future__ import annotations

import contextlib
import os
import re
import signal
import socket
import threading
import time
from collections.abc import Callable, Container, Sequence
from dataclasses import dataclass, replace
from typing import IO, Any

from grader.course.message import FaultError
from grader.execution.crash_location import CrashLocation, fault, from_page, from_report
from grader.execution.records import Cause, Death
from grader.worker import frames

ANSWER_SECONDS = 20  # for the worker itself, which runs no code but ours
GRACE_SECONDS = 1  # between the end of a session's socket and the end of its process
UBSAN_EXIT = 1
MAX_TEXT = 20_000  # characters of output that are kept

# Ends the session's process after so many seconds, having it note where it is first if so asked;
# returns its wait status and CPU seconds.
Reap = Callable[[float, bool], tuple[int, float]]
Release = Callable[[float], None]  # lets it end by itself in so many seconds

_SANITIZER = re.compile(
    r"ERROR: AddressSanitizer:? (?:attempting )?([\w-]+)|(?:\S+): runtime error: (.*)"
)
_NULL = "Hint: address points to the zero page"
_RUNTIME_ERROR = re.compile(r"^(?:\./)?([\w.]+\.[ch]):(\d+):\d+: runtime error", re.MULTILINE)
# What the sanitizers and the loader write themselves: from its error on, all is a sanitizer's;
# before, some lines are ASan's warnings and advice, the calls that it lists, and the loader's.
_REPORT = re.compile(
    r"(?:AddressSanitizer:DEADLYSIGNAL\n)?(?:=+\n)?==\d+==ERROR: AddressSanitizer(?s:.*)"
    r"|^[^\n]*: runtime error: (?s:.*)"
    r"|^[^\n]*: symbol lookup error: .*\n?"
    r"|^==\d+==.*\n?|^False positive error reports may follow\n?"
    r"|^For details see https://github\.com/google/sanitizers.*\n?"
    r"|^ +#\d+ 0x[0-9a-f]+ .*\n?",
    re.MULTILINE,
)


class MachineError(FaultError):
    """The worker failed without running the submission: the grader's or the machine's fault."""


class NotLocked(Exception):
    """A session did not say that it is shut in."""


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
    """Bounds of one session: CPU seconds, and bytes of memory beyond what the worker uses.

    The seconds are those of the whole session; with `each_call`, of each request, for a session
    that stays.
    """

    cpu: float = 10.0
    memory: int = 512 << 20
    each_call: bool = False

    @property
    def wall(self) -> float:
        """Seconds of waiting for one answer: generous, a loaded machine is not the code's fault."""
        return 3 * self.cpu + 2


def printable(text: str) -> str:
    """Return a text without the control characters that could fool a terminal."""
    return "".join(each if each.isprintable() or each in "\n\t" else "�" for each in text)


class SessionSocket:
    """The parent's side of one session. A thread may interrupt what another waits for."""

    def __init__(
        self,
        reap: Reap,
        release: Release,
        sock: socket.socket,
        files: Sequence[IO[bytes]],
        limits: Limits,
        library: str,
    ) -> None:
        self._reap, self._release, self._sock = reap, release, sock
        self._files, self._limits, self._library = files, limits, library
        self._replies = frames.Reader(sock)
        self._requests: list[bytes] = []  # that wait for the next one which has an answer
        self._variables: set[str] = set()  # that they write
        self._ended = False
        self._waiting = False  # for an answer: for ever, if an exception cut the wait short
        self._death: Death | None = None
        self._burying = threading.Lock()

    def begin(self) -> None:
        """Wait until the library is loaded.

        Raises NotLocked when the process was not shut in, and Died as `ask` does.
        """
        deadline = time.monotonic() + ANSWER_SECONDS
        try:
            head, _ = self._replies.frame(0, deadline)
        except (OSError, EOFError, ValueError) as error:
            raise NotLocked(repr(error)) from error
        if head.get("is") != "locked":
            raise NotLocked(head.get("is"))
        self._hear(0, (), 0)

    def set(self, name: str, payload: bytes) -> None:
        """Write a global variable, before the next request; `ask` then raises what this may."""
        self._requests.append(frames.frame({"do": "set", "name": name}, payload))
        self._variables.add(name)

    def ask(self, head: dict[str, Any], size: int, payload: bytes = b"") -> bytes | bytearray:
        """Send a request and return its answer of exactly `size` bytes.

        Raises Died, or Missing; ValueError when the session is over.
        """
        if self._ended or self._waiting:
            raise ValueError("the session is over, or was interrupted")
        self._waiting = True
        place = 0  # of the answer, in the shared memory
        if max(size, len(payload)) >= frames.LARGE_BYTES:
            place = frames.answer_offset(len(payload))
        if place and place + size <= frames.SHARED_BYTES:
            os.pwrite(self._files[2].fileno(), payload, frames.ROOM_OFFSET)
            head, payload = {**head, "room": len(payload)}, b""
        try:
            self._sock.settimeout(self._limits.wall)
            self._sock.sendall(b"".join((*self._requests, frames.frame(head, payload))))
        except OSError:
            pass  # it has died: hearing says how
        names = {head.get("function") or head.get("name") or "", *self._variables}
        self._requests.clear()
        self._variables.clear()
        return self._hear(size, names, place)

    def _hear(self, size: int, names: Container[str], place: int) -> bytes | bytearray:
        """Wait for an answer of `size` bytes, about the things of these names.

        All that comes may be the submission's own work: no answer is the grader's fault.
        """
        deadline = time.monotonic() + self._limits.wall
        try:
            head, answer = self._replies.frame(max(size, MAX_TEXT), deadline)
        except TimeoutError:
            raise Died(self._bury(0, Cause.TIMEOUT)) from None
        except (OSError, EOFError, ValueError, RecursionError):
            raise Died(self._bury(GRACE_SECONDS, Cause.EXIT)) from None
        self._waiting = False
        kind = head.get("is")
        if kind == "done" and place and head.get("room") == size:
            return self._from_room(size, place)
        if kind == "done" and len(answer) == size:
            return answer
        text = printable(answer[:MAX_TEXT].decode(errors="replace"))
        name = text.removeprefix("missing: ")
        if kind == "refused" and name != text and name in names:
            raise Missing(name)
        causes = {"stray": Cause.STRAY_WRITE, "unloadable": Cause.LOAD, "memory": Cause.MEMORY}
        death = self._bury(0, causes.get(str(kind), Cause.EXIT))
        raise Died(replace(death, text=text or death.text))

    def _from_room(self, size: int, place: int) -> bytearray:
        # Zeros where the code may have shortened the file.
        answer = bytearray(size)
        os.preadv(self._files[2].fileno(), [answer], place)
        return answer

    def marks(self) -> bytes:
        """Return the page of MRT_TODO markers, one byte each, even after a crash."""
        return self._page()[: frames.TODO_BYTES]

    def output(self) -> str:
        """Return the beginning of what the code wrote on stdout, then stderr.

        What a sanitizer or the loader reports is not the code's own, and is left out.
        """
        return self._written(0) + _REPORT.sub("", self._written(1))

    def printed_since(self) -> str:
        """Return `output`, and forget it: the next time, only what is new comes."""
        text = self.output()
        for each in self._files[:2]:
            os.ftruncate(each.fileno(), 0)  # they are written at their end, wherever that is
        return text

    def interrupt(self) -> Death:
        """End the session now, whatever it does; return where it was."""
        return self._bury(0, Cause.TIMEOUT)

    def close(self) -> None:
        """End the session."""
        if not self._ended:
            self._ended = True
            with contextlib.suppress(OSError):
                self._sock.settimeout(GRACE_SECONDS)
                self._sock.sendall(frames.frame({"do": "close"}))
            with contextlib.suppress(MachineError):  # without the worker it is over anyway
                self._release(0 if self._waiting else GRACE_SECONDS)
        self._sock.close()
        for each in self._files:
            each.close()

    def _written(self, number: int) -> str:
        data = os.pread(self._files[number].fileno(), MAX_TEXT, 0)
        return printable(data.decode(errors="replace"))

    def _page(self) -> bytes:
        # Read, not mapped: the code may have shortened the file, which would kill who maps it.
        page = os.pread(self._files[2].fileno(), frames.PAGE_BYTES, 0)
        return page.ljust(frames.PAGE_BYTES, b"\0")

    def _bury(self, grace: float, cause: Cause) -> Death:
        """End the process, once; say why it died, by `cause` when its end does not tell."""
        with self._burying:
            if self._death is None and not self._ended:
                self._ended = True
                status, cpu = self._reap(grace, cause is Cause.TIMEOUT)
                self._death = self._explain(status, cpu, cause)
            return self._death or Death(Cause.EXIT)

    def _explain(self, status: int, cpu: float, cause: Cause) -> Death:
        page, text = self._page(), self._written(1) + self._written(0)
        (case,) = frames.COUNTER.unpack_from(page, frames.TODO_BYTES)
        code = os.waitstatus_to_exitcode(status)
        # Code that ignores the first signal is killed by the kernel a second later.
        if code == -signal.SIGXCPU or (code == -signal.SIGKILL and cpu >= self._limits.cpu):
            cause = Cause.TIMEOUT
        if cause in (Cause.LOAD, Cause.STRAY_WRITE, Cause.MEMORY):
            return Death(cause, case=case, text=text)
        if code == -signal.SIGKILL and cause is Cause.EXIT:
            cause = Cause.KILLED
        # Where UBSan cannot read its settings it ends by exit instead of a signal.
        reported = code == UBSAN_EXIT and _SANITIZER.search(text) is not None
        if cause is Cause.EXIT and (reported or code < 0):
            cause = Cause.SIGNAL
        word = _word(code, page, text) if cause is Cause.SIGNAL else ""
        code = max(code, 0) if cause is Cause.EXIT else 0
        first, *callers = _calls(self._library, page, text) or [CrashLocation("", "")]
        return Death(
            cause,
            word,
            code,
            case,
            first.location,
            text,
            first.function,
            tuple((each.function, each.location) for each in callers),
            self._limits.cpu,
        )


def _word(code: int, page: bytes, text: str) -> str:
    """Return how the code ended: as a sanitizer reports it, else as the signal tells."""
    report = _SANITIZER.search(text)
    if report is not None:
        word = report[1] or f"runtime error: {report[2]}"
        return "null-pointer" if word == "SEGV" and _NULL in text else word
    name = signal.Signals(-code).name if code < 0 else ""
    return (fault(page) if name == "SIGSEGV" else "") or name


def _calls(library: str, page: bytes, text: str) -> list[CrashLocation]:
    """Return the calls that ran: as a sanitizer reports them, else as the shim noted them."""
    calls = from_report(library, text) or from_page(library, page)
    found = _RUNTIME_ERROR.search(text)
    if not found:
        return calls
    # The line of the error is its own report's; the rest of the calls is in the page.
    place = CrashLocation(calls[0].function if calls else "", f"{found[1]}:{found[2]}")
    return [place, *calls[1:]]
