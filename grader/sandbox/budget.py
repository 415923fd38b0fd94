"""What one submission may take in all: seconds of waiting, of computing, and of doing neither.

Each compilation and each call has a limit of its own; what stays below all of them would still last
for hours. A right program takes a tenth of the first two and nothing of the third: code that is
asked for something, and neither computes nor queues for a processor, waits on purpose.

The clock of the first is slowed by the load of the machine, as measured: with twice as many
processes that want to run as there are processors, a minute counts half. The others need not be,
since they are counted by the kernel for the process itself.
"""

from __future__ import annotations

import math
import os
import threading
import time
from collections.abc import Callable, Mapping

WALL, CPU, ASLEEP = "wall", "cpu", "asleep"
SECONDS = {WALL: 120.0, CPU: 120.0, ASLEEP: 10.0}
# After so many calls that do not end, the others get that share of their time: who loops in one
# function after the other would have it all each time.
LOOPS, SHARE = 4, 0.5
MOST_LOAD = 10.0  # beyond that the figure is no longer about this submission


def load() -> float:
    """Return how many processes want to run for each processor; 1 at least."""
    try:
        wanting = os.getloadavg()[0] / (os.cpu_count() or 1)
    except OSError:
        wanting = 1.0
    return min(max(wanting, 1.0), MOST_LOAD)


class Budget:
    """The seconds of one submission. Threads share it."""

    def __init__(
        self,
        seconds: Mapping[str, float] | None = None,
        clock: Callable[[], float] = time.monotonic,
        load: Callable[[], float] = load,
    ) -> None:
        self._seconds = seconds or SECONDS
        self._clock, self._load = clock, load
        self._seen = clock()
        self._used = dict.fromkeys(SECONDS, 0.0)
        self._loops = 0
        self._busy = threading.Lock()

    @classmethod
    def endless(cls) -> Budget:
        """Return that of what is no submission, or of a person's own session."""
        return cls(dict.fromkeys(SECONDS, math.inf))

    def spend(self, cpu: float = 0.0, asleep: float = 0.0, loops: int = 0) -> None:
        """Note seconds that the submission has taken, and calls that computed until their end."""
        with self._busy:
            self._used[CPU] += cpu
            self._used[ASLEEP] += asleep
            self._loops += loops

    @property
    def share(self) -> float:
        """What of its seconds a call may still take."""
        return SHARE if self._loops >= LOOPS and self._seconds[CPU] < math.inf else 1.0

    def left(self, kind: str = WALL) -> float:
        """Return how many seconds of a kind are left, of wall time as they pass now."""
        left = max(self._seconds[kind] - self._count()[kind], 0.0)
        return left * self._load() if kind == WALL else left

    @property
    def spent(self) -> str:
        """The kind that is used up, "" as long as there is something left of each."""
        used = self._count()
        return next((kind for kind in SECONDS if used[kind] >= self._seconds[kind]), "")

    def _count(self) -> dict[str, float]:
        with self._busy:
            now = self._clock()
            self._used[WALL] += (now - self._seen) / self._load()
            self._seen = now
            return dict(self._used)
