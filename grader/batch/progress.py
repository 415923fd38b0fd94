"""What the terminal shows while a class is graded: a line that moves, or plain lines when piped."""

from __future__ import annotations

import time
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

from grader.course.texts import Texts

PLAIN_SECONDS = 5.0  # between two plain lines


class Meter:
    """Counts what is done, how fast, what is left, and what failed; a context manager."""

    def __init__(self, texts: Texts, total: int, console: Console) -> None:
        self._texts, self._total, self._console = texts, total, console
        self._done = self._failed = 0
        self._start = self._said = time.monotonic()
        self._bar: Progress | None = None
        self._task: Any = None

    def __enter__(self) -> Meter:
        if self._console.is_terminal and self._total:
            columns = (BarColumn(), MofNCompleteColumn(), TextColumn("{task.description}"))
            self._bar = Progress(*columns, console=self._console, transient=True)
            self._bar.start()
            self._task = self._bar.add_task("", total=self._total)
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar:
            self._bar.stop()

    def step(self, failed: bool) -> None:
        """Count one more."""
        self._done += 1
        self._failed += failed
        now = time.monotonic()
        if self._bar:
            self._bar.update(self._task, completed=self._done, description=self._state(now))
        elif now - self._said >= PLAIN_SECONDS or self._done == self._total:
            self._said = now
            line = f"{self._done}/{self._total} {self._state(now)}"
            self._console.print(line, markup=False, highlight=False, soft_wrap=True)

    def _state(self, now: float) -> str:
        spent = max(now - self._start, 1e-3)
        left = spent / self._done * (self._total - self._done)
        return self._texts.say(
            "batch.progress",
            rate=self._texts.number(round(60 * self._done / spent, 1)),
            left=f"{int(left) // 60}:{int(left) % 60:02d}",
            failed=self._failed,
        )
