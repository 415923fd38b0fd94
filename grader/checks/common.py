"""What the checks of TP2 to TP5 share.

The inputs and the reference's answers are stored (grader/expected.py); each check makes the calls
of its suites and looks at one side of the answers.
"""

from __future__ import annotations

from grader.compare import MATERIAL
from grader.judge import Student


def check_answers(student: Student, suite: str, *picks: str) -> None:
    """Compare parts of the answers to a suite."""
    for trial in student.trials(suite):
        trial.expect(*picks)


def check_refusals(student: Student, *suites: str) -> None:
    """Look at the calls that must return false: they do, and change nothing."""
    for suite in suites:
        for trial in student.trials(suite):
            trial.expect("result", where=trial.refused)
            trial.expect_kept("r", "it", where=trial.refused)


def check_material(student: Student, suite: str) -> None:
    """Look for the whole material of what is hit."""
    check_answers(student, suite, *(f"it.mat.{name}" for name in MATERIAL))


def check_results(student: Student, *suites: str) -> None:
    """Compare what the calls of suites return."""
    for suite in suites:
        check_answers(student, suite, "result")
