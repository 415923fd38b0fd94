"""Pictures drawn beside the checks of functions, by threads of their own.

A picture waits until all that it needs has passed its own checks: what loops, or is not written, is
known by then, and is never drawn ahead. What is not begun when its turn comes is run then: in the
end all threads draw, from either side.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass

from grader.course.exercises import Manifest
from grader.evaluation.records import Outcome


@dataclass(frozen=True)
class RunResult:
    """What a check raised, and how long it took, seconds."""

    error: Exception | None
    seconds: float


MOST_THREADS = 4  # more would only wait for the last pictures, which take longest


class Prefetch:
    """The pictures of one run; `run` runs a check by its id, in one of so many threads."""

    def __init__(self, rules: Manifest, run: Callable[[str], RunResult], threads: int = 1) -> None:
        self._rules, self._run = rules, run
        self._threads = min(threads, MOST_THREADS)
        self._pool = ThreadPoolExecutor(max(self._threads, 1))
        self._waiting: dict[str, set[str]] = {}  # pictures, for the checks that are to pass
        self._ready: list[str] = []
        self._begun: dict[str, Future[RunResult]] = {}
        self._choosing = threading.Lock()

    def order(self, checks: Sequence[str]) -> list[str]:
        """Return the checks in the order to run them in, and begin to draw what waits for nothing.

        Those that pictures wait for come first, what only a bonus needs behind: the later stages
        take longest. Pictures come last.
        """
        rules = self._rules.checks()
        functions = [name for name in checks if not rules[name].is_picture]
        for name in (each for each in checks if rules[each].is_picture):
            exercises = {*self._rules.needed(rules[name]), rules[name].exercise}
            self._waiting[name] = {each for each in functions if rules[each].exercise in exercises}
        awaited = set[str]().union(*self._waiting.values())
        self._begin()

        def place(name: str) -> tuple[bool, bool, bool]:
            if rules[name].is_picture:
                return True, False, False
            return False, name not in awaited, self._rules.exercise(rules[name].exercise).bonus

        return sorted(checks, key=place)

    def heard(self, check: str, outcome: Outcome) -> None:
        """Draw what has waited for this check alone; never ahead what it has not passed for."""
        for name, awaited in list(self._waiting.items()):
            if check in awaited and outcome is not Outcome.PASSED:
                del self._waiting[name]
            awaited.discard(check)
        self._begin()

    def result(self, check: str) -> RunResult | None:
        """Wait for a check that was begun; None when it was not, and no more will be."""
        with self._choosing:
            self._waiting.pop(check, None)
            if check in self._ready:
                self._ready.remove(check)
        return self._begun[check].result() if check in self._begun else None

    def close(self) -> None:
        """Begin nothing more; what runs ends with the worker that draws it."""
        self._pool.shutdown(wait=False, cancel_futures=True)

    def _begin(self) -> None:
        if not self._threads:
            return
        ready = [name for name, awaited in self._waiting.items() if not awaited]
        with self._choosing:
            for name in ready:
                del self._waiting[name]
            self._ready += ready
        for _ in ready:
            self._pool.submit(self._draw)

    def _draw(self) -> None:
        """Draw one picture that is ready: the last one, since later stages take longer."""
        with self._choosing:
            if not self._ready:
                return
            name = self._ready.pop()
            self._begun[name] = Future()
        self._begun[name].set_result(self._run(name))
