"""The checks that are a line of exercises.toml: as pytest selects and reports the others."""

from __future__ import annotations

import pytest

from grader.checking.student import Student
from grader.checks.lines import Act, act_of
from grader.course import exercises

LINES = {name: each.line for name, each in exercises.load().checks().items() if each.line}


@pytest.mark.parametrize(
    "act",
    [
        pytest.param(act_of(name, line), id=name, marks=pytest.mark.check(name))
        for name, line in LINES.items()
    ],
)
def test_line(student: Student, act: Act) -> None:
    """Look at what the line says."""
    act(student)
