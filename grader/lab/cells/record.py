"""What is known of each exercise: the checks of every notebook, kept in build/lab/, and the grade.

What was seen last counts.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from grader.course import exercises
from grader.course.exercises import Exercise
from grader.evaluation.records import ExerciseResult, Outcome
from grader.lab.display import store
from grader.lab.display.links import graded

FILE = "checks.json"
_START = time.time()  # of this session


@dataclass(frozen=True)
class Known:
    """An exercise, and what became of it when it was last looked at; None: never."""

    exercise: Exercise
    outcome: Outcome | None = None
    points: float = 0.0
    when: str = ""  # this_session, earlier_check, last_grade: keys of [lab]


def keep(result: ExerciseResult) -> None:
    """Note what checks have just said."""
    row = {"outcome": result.outcome.value, "points": result.points / 100, "at": time.time()}
    with contextlib.suppress(OSError):  # a disk that is full is told where something is lost
        store.write(FILE, {**store.read(FILE), result.id: row})


def known() -> list[Known]:
    """Return every exercise that has checks, in the course's order."""
    checks, grade = store.read(FILE), graded()
    rows = {each["id"]: each for each in grade.get("exercises", [])}
    at = _moment(grade)
    return [
        _latest(each, checks.get(each.id), rows.get(each.id), at)
        for each in exercises.load().exercises
        if each.checks
    ]


def _moment(grade: Mapping[str, Any]) -> float:
    try:
        return datetime.fromisoformat(grade["graded_at"]).timestamp()
    except (KeyError, TypeError, ValueError):
        return 0.0


def _latest(exercise: Exercise, check: Any, row: Any, at: float) -> Known:
    with contextlib.suppress(KeyError, TypeError, ValueError):  # a file that somebody has changed
        if check and (not row or check["at"] >= at):
            when = "this_session" if check["at"] >= _START else "earlier_check"
            return Known(exercise, Outcome(check["outcome"]), float(check["points"]), when)
    if row:
        return Known(exercise, Outcome(row["outcome"]), float(row["points"]), "last_grade")
    return Known(exercise)


def following(rows: Iterable[Known]) -> Exercise | None:
    """Return the exercise to work on: what is wrong, then what is to do, bonuses last.

    What was never looked at comes after that, and last what waits for another one.
    """

    def order(each: Known) -> tuple[bool, bool, bool, bool]:
        unwritten = each.outcome in (None, Outcome.TODO)
        waits = each.outcome is Outcome.BLOCKED
        return waits, unwritten, each.exercise.bonus, each.outcome is None

    left = _left(rows)
    return min(left, key=order).exercise if left else None


def after(rows: Sequence[Known], name: str, waits_for: Iterable[str] = ()) -> Exercise | None:
    """Return the exercise to work on behind one that is right, or that waits for others.

    Onwards from there; but what it waits for comes first where that stands before it. What was
    left behind, and bonuses, come last.
    """
    places = {each.exercise.id: number for number, each in enumerate(rows)}
    before = [each for each in waits_for if places.get(each, len(rows)) < places[name]]

    def order(each: Known) -> tuple[bool, bool, bool]:
        own = each.exercise
        return own.id not in before, own.bonus, places[own.id] < places[name]

    left = [each for each in _left(rows) if each.exercise.id != name]
    return min(left, key=order).exercise if left else None


def _left(rows: Iterable[Known]) -> list[Known]:
    return [each for each in rows if each.outcome is not Outcome.PASSED]
