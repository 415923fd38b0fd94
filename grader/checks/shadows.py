"""What the checks of in_shadow share."""

from __future__ import annotations

from grader.checking.student import Student
from grader.checks.common import check_results

FOUND = 0.5  # of the shadows: that none is seen where there is none counts for who sees as many


def check_bars(student: Student, suite: str) -> None:
    """Compare where there is no shadow; it counts for who sees some."""
    for trial in student.trials("in_shadow.blocked"):
        barred = ~trial.refused
        if barred.any() and trial.got("result")[barred].mean() < FOUND:
            trial.expect("result", where=barred)
    check_results(student, suite)


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
