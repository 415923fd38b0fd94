"""What the checks of in_shadow share."""

from __future__ import annotations

from grader.checking.student import Answers, CallDied, Student, Wrong
from grader.checks.common import check_results

FOUND = 0.5  # of the shadows: that none is seen where there is none counts for who sees as many


def check_bars(student: Student, suite: str) -> None:
    """Compare where there is no shadow; it counts for who sees some, be it from near only."""
    for trial in student.trials("in_shadow.blocked"):
        if not _found(trial) and not _sees(student, "in_shadow.near"):
            trial.expect("result", where=~trial.refused)
    check_results(student, suite)


def _sees(student: Student, suite: str) -> bool:
    """Say whether most of the shadows of a suite are seen; what is wrong in it is not noted."""
    try:
        with student.unnoted():
            return all(map(_found, student.trials(suite)))
    except (Wrong, CallDied):
        return False


def _found(trial: Answers) -> bool:
    barred = ~trial.refused
    return not barred.any() or bool(trial.got("result")[barred].mean() >= FOUND)


def check_near(student: Student, suite: str) -> None:
    """Compare where there is a shadow; it counts for who does not see one everywhere."""
    expect_free(student)
    check_results(student, suite)


def expect_free(student: Student) -> None:
    """Raise Wrong where everything is called a shadow."""
    for trial in student.trials("in_shadow.blocked"):
        free = trial.refused
        if free.any() and trial.got("result")[free].mean() > FOUND:
            trial.expect("result", where=free)
