"""Judging a mutant by the grader's own checks, the quickest first.

The checks of the exercises that own the changed function come first, one by one, up to the first
that fails: what they need beside it is the reference's own, so that a failure costs points. A
mutant that they all let pass is graded as a whole, as a submission is.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path

from grader.authoring.proof.mutants_changes import Mutant
from grader.authoring.proof.mutants_family import Kit
from grader.authoring.proof.mutants_source import owners
from grader.authoring.specimens import patches
from grader.authoring.specimens.grading import graded, lost
from grader.checking.expected_data import FOLDER
from grader.checking.student import CallDied, Student, Wrong
from grader.checks import __path__ as checks_path
from grader.checks.lines import act_of
from grader.course import exercises
from grader.course.exercises import Check
from grader.execution.worker_process import Died, Missing


def caught_soon(kit: Kit, mutant: Mutant, first: str) -> str:
    """Return the check in which a mutant that has been chosen loses points; "" when none.

    Only the checks of the exercises that own the function are run. `first` is a check to begin
    with, "" for none: the one that has caught it before.
    """
    return next((each.id for each in _order(mutant, first) if fails(kit, each)), "")


def caught_late(mutant: Mutant, cache: Path) -> str:
    """Return a check in which a mutant loses points when all is graded, "" when there is none."""
    found = lost(graded(patches.submission(mutant.function, mutant.files()), cache))
    return found[0].id if found else ""


def _order(mutant: Mutant, first: str) -> Sequence[Check]:
    """Return the checks of the exercises that own the function: pictures last."""
    own = [check for name in owners(mutant.file, mutant.function) for check in _of(name)]
    return sorted(own, key=lambda each: (each.id != first, each.is_picture))


def _of(exercise: str) -> Sequence[Check]:
    return exercises.load().exercise(exercise).checks


def fails(kit: Kit, check: Check) -> bool:
    """Say whether a check costs points."""
    exercise = exercises.load().exercise(check.exercise)
    student = Student(kit, FOLDER, exercise.functions)
    try:
        _tests()[check.id](student)
    except Wrong as error:
        return round(error.evidence.share * check.points) < check.points
    except (CallDied, Died, Missing):
        return True
    return False


@cache
def _tests() -> Mapping[str, Callable[[Student], None]]:
    """Return the function of each check, by its id."""
    rules = exercises.load().checks()
    found = {name: act_of(name, each.line) for name, each in rules.items() if each.line}
    for path in sorted(Path(checks_path[0]).glob("test_*.py")):
        module = importlib.import_module(f"grader.checks.{path.stem}")
        for value in vars(module).values():
            for mark in getattr(value, "pytestmark", ()):
                if mark.name == "check":
                    found[mark.args[0]] = value
    return found
