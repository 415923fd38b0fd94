"""The parent's side of a session: asking, hearing, and saying how its process ended.

Every wait has a deadline. Whatever comes back may be the submission's own work: it is checked for
its length, and is never more than a wrong answer or none.
"""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import threading
import time
from collections.abc import Callable, Container, Sequence
from dataclasses import replace
from typing import IO, Any

from grader.course.message import FaultError
from grader.execution import session_report
from grader.execution.crash_location import CrashLocation
from grader.execution.memory_watch import MemoryWatch
from grader.execution.patience import Patience, Seconds
from grader.execution.peer import ask_for_sender, sender
from grader.execution.records import OUT_OF_TIME, Cause, Death, Limits
from grader.execution.session_report import MAX_TEXT, printable
from grader.sandbox.budget import Budget
from grader.worker import frames

ANSWER_SECONDS = 20  # for the worker itself, which runs no code but ours
# What an answer of the session tells that is none.
_CAUSES = {
    "stray": Cause.STRAY_WRITE,
    "unset": Cause.UNSET_RESULT,
    "unloadable": Cause.LOAD,
    "memory": Cause.MEMORY,
}
GRACE_SECONDS = 1  # between the end of a session's socket and the end of its process

# Ends its process after so many seconds, first noting where it is if so asked: status, CPU seconds.
Reap = Callable[[float, bool], tuple[int, float]]
Release = Callable[[float], None]  # lets it end by itself in so many seconds


class MachineError(FaultError):
    """The worker failed without running the submission: the grader's or the machine's fault."""


class NotLocked(Exception):
    """A session did not say that it is shut in."""


class Died(Exception):
    """The process that ran the submission is gone; `death` says how."""

    def __init__(self, death: Death) -> None:
        super().__init__(f"{death.cause.value} {death.word} {death.location}".strip())
        self.death = death


class Overdrawn(Exception):
    """A check took more than its seconds, in a process whose limit was that of others as well."""


class Missing(Exception):
    """The submission lacks this function or global variable."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.name = name


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
        budget: Budget,
        watch: MemoryWatch,
    ) -> None:
        self._reap, self._release, self._sock = reap, release, sock
        self._files, self._limits, self._library = files, limits, library
        self._budget = budget  # of the submission
        self._watch = watch  # of its memory
        self._pid = 0  # 0: not known, or not yet
        self._first_page = b""  # as it was before the first request; b"": there is no renewing
        self._counted = 0.0  # CPU seconds that the budget knows of
        ask_for_sender(sock)
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
            self._sock.settimeout(ANSWER_SECONDS)
            self._pid = sender(self._sock)
            head, _ = self._replies.frame(0, deadline)
        except (OSError, EOFError, ValueError) as error:
            raise NotLocked(repr(error)) from error
        if head.get("is") != "locked":
            raise NotLocked(head.get("is"))
        if self._hear(1 if self._limits.each_check else 0, (), 0) == b"\1":
            self._first_page = self.page()

    def renew(self) -> None:
        """Have everything be as before the first request, from the next one on."""
        self._requests.clear()
        self._variables.clear()
        self._forget_words()
        os.pwrite(self._files[2].fileno(), self._first_page, 0)
        self._requests.append(frames.frame({"do": "renew"}))

    @property
    def can_serve_on(self) -> bool:
        """Whether the process is there, and can be renewed."""
        return bool(self._first_page) and not self._ended and not self._waiting

    def settle(self) -> None:
        """Note the CPU seconds of a check that has ended well. Raises Overdrawn."""
        if self._spend(Seconds.of(self._pid).running) >= self._limits.cpu:
            raise Overdrawn

    def _spend(self, cpu: float, loops: int = 0) -> float:
        """Note the CPU seconds of the process in all; return those that are new."""
        taken = max(cpu - self._counted, 0.0)
        self._counted += taken
        self._budget.spend(cpu=taken, loops=loops)
        return taken

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
        names = {head.get("name") or "", *self._variables}
        self._requests.clear()
        self._variables.clear()
        return self._hear(size, names, place)

    def _hear(self, size: int, names: Container[str], place: int) -> bytes | bytearray:
        """Wait for an answer of `size` bytes, about the things of these names.

        All that comes may be the submission's own work: no answer is the grader's fault.
        """
        try:
            head, answer = self._answer(max(size, MAX_TEXT))
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
        death = self._bury(0, _CAUSES.get(str(kind), Cause.EXIT))
        raise Died(replace(death, text=text or death.text))

    def _answer(self, limit: int) -> tuple[dict[str, Any], bytes]:
        """Wait for a frame as long as there is patience. Raises Died, and what frames do."""
        patience = Patience(self._pid, self._limits.wall, self._budget)
        while True:
            try:
                return self._replies.frame(limit, patience.until)
            except TimeoutError:
                if why := patience.lost():
                    raise Died(self._bury(0, *why)) from None

    def _from_room(self, size: int, place: int) -> bytearray:
        # Zeros where the code may have shortened the file.
        answer = bytearray(size)
        os.preadv(self._files[2].fileno(), [answer], place)
        return answer

    def output(self) -> str:
        """Return the beginning of what the code wrote on stdout, then stderr.

        What a sanitizer or the loader reports is not the code's own, and is left out.
        """
        return self._written(0) + session_report.own_words(self._written(1))

    def printed_since(self) -> str:
        """Return `output`, and forget it: the next time, only what is new comes."""
        text = self.output()
        self._forget_words()
        return text

    def _forget_words(self) -> None:
        for each in self._files[:2]:
            os.ftruncate(each.fileno(), 0)  # they are written at their end, wherever that is

    def interrupt(self) -> Death:
        """End the session now, whatever it does; return where it was."""
        return self._bury(0, Cause.TIMEOUT)

    def close(self) -> None:
        """End the session."""
        if not self._ended:
            self._ended = True
            self._spend(Seconds.of(self._pid).running)
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

    def page(self) -> bytes:
        """Return the page that the process shares with us, even after a crash."""
        # Read, not mapped: the code may have shortened the file, which would kill who maps it.
        page = os.pread(self._files[2].fileno(), frames.PAGE_BYTES, 0)
        return page.ljust(frames.PAGE_BYTES, b"\0")

    def _bury(self, grace: float, cause: Cause, word: str = "", seconds: float = 0.0) -> Death:
        """End the process, once; say why it died, by `cause` when its end does not tell."""
        with self._burying:
            if self._death is None and not self._ended:
                self._ended = True
                status, cpu = self._reap(grace, cause in OUT_OF_TIME)
                self._death = self._explain(status, cpu, cause)
                self._spend(cpu, loops=self._death.cause is Cause.TIMEOUT)
                if self._death.cause in (Cause.WAITING, Cause.SPENT):
                    self._death = replace(self._death, word=word, seconds=seconds)
            return self._death or Death(Cause.EXIT)

    def _explain(self, status: int, cpu: float, cause: Cause) -> Death:
        page, text = self.page(), self._written(1) + self._written(0)
        (case,) = frames.COUNTER.unpack_from(page, frames.TODO_BYTES)
        code = os.waitstatus_to_exitcode(status)
        # Code that ignores the first signal is killed by the kernel a second later.
        if code == -signal.SIGXCPU or (code == -signal.SIGKILL and cpu >= self._limits.cpu):
            cause = Cause.TIMEOUT
        if self._watch.has_ended(self._pid):
            cause = Cause.MEMORY
        if cause in (Cause.LOAD, Cause.STRAY_WRITE, Cause.MEMORY):
            return Death(cause, case=case, text=text)
        if code == -signal.SIGKILL and cause is Cause.EXIT:
            cause = Cause.KILLED
        if cause is Cause.EXIT and (code < 0 or session_report.is_reported(code, text)):
            cause = Cause.SIGNAL
        word = session_report.word(code, page, text) if cause is Cause.SIGNAL else ""
        code = max(code, 0) if cause is Cause.EXIT else 0
        calls = session_report.calls(self._library, page, text, word)
        first, *callers = calls or [CrashLocation("", "")]
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
