"""How long the answer of a session is waited for.

A process that is asked for something computes, or queues for a processor because the machine is
busy, which is not its fault; or it does neither, and waits on purpose. The kernel counts the first
two, so that the third is known whatever the load.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

from grader.execution.records import Cause
from grader.sandbox.budget import ASLEEP, SECONDS, Budget

FIRST_LOOK, LOOK_SECONDS = 0.02, 0.25  # after it the time doubles, up to the second


@dataclass(frozen=True)
class Seconds:
    """How long a process has been running, and queueing for a processor, in all.

    `resting`: it sleeps or is stopped now. Else it may be in the queue, for a time not yet counted.
    """

    running: float = 0.0
    queueing: float = 0.0
    resting: bool = False
    known: bool = True

    @classmethod
    def of(cls, pid: int) -> Seconds:
        """Return those of a process; zeros, not known, where the system does not tell."""
        try:
            counted = _content(f"/proc/{pid}/schedstat") if pid else b""
            running, queueing = map(int, counted.split()[:2])
            state = _content(f"/proc/{pid}/stat").rpartition(b")")[2].split()[0]
        except (OSError, ValueError, IndexError):
            return cls(known=False)
        return cls(running / 1e9, queueing / 1e9, state in (b"S", b"T", b"t"))


def _content(path: str) -> bytes:
    """Read a file of /proc, in a fifth of pathlib's time: twice for each answer."""
    with open(path, "rb", buffering=0) as file:
        return file.read()


class Patience:
    """The wait for one answer: at `until`, when there was none, `lost` says whether to give up.

    `wall` are the seconds that an answer may take, on a machine that is not busy.
    """

    def __init__(self, pid: int, wall: float, budget: Budget) -> None:
        self._pid, self._wall, self._budget = pid, wall, budget
        self._start, self._before = time.monotonic(), Seconds.of(pid)
        self._step, self._asleep = FIRST_LOOK, 0.0
        self.until = self._start + self._step

    def lost(self) -> tuple[Cause, str, float] | None:
        """Return why to wait no longer (cause, its word, seconds), or move `until`."""
        seconds, now = Seconds.of(self._pid), time.monotonic()
        elapsed = now - self._start
        queued, asleep = 0.0, 0.0
        if seconds.known and self._before.known:
            queued = seconds.queueing - self._before.queueing
            asleep = max(elapsed - queued - (seconds.running - self._before.running), 0.0)
        if seconds.resting and asleep > self._asleep:
            # There is no answer yet: all this time is the code's own.
            self._budget.spend(asleep=asleep - self._asleep)
            self._asleep = asleep
        if kind := self._budget.spent:
            return Cause.SPENT, kind, SECONDS[kind]
        if elapsed - queued >= self._wall:
            if self._asleep > elapsed / 2:
                return Cause.WAITING, "", round(self._asleep)
            return Cause.TIMEOUT, "", 0.0
        self._step = min(2 * self._step, LOOK_SECONDS)
        left = (self._wall + queued - elapsed, self._budget.left(ASLEEP), self._budget.left())
        self.until = now + max(min(self._step, *left), 0.001)
        return None
