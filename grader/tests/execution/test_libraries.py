"""What is built of a submission, and when."""

from __future__ import annotations

from pathlib import Path

import pytest

from grader.build.records import Target
from grader.course import sizes
from grader.course.exercises import CORE
from grader.execution.libraries import Libraries
from grader.intake import originals
from grader.intake.submission import read_submission
from grader.tests.support.judging import REFERENCE

UNIT, DRAWN, PLAIN = (
    Target(*sizes.UNIT, sanitized=True),
    Target(*sizes.PICTURE, sanitized=True),
    Target(*sizes.PICTURE),
)


def targets(libraries: Libraries) -> list[Target]:
    """Return what was built, or is being built, for the report."""
    return [each.target for each in libraries.builds]


def test_all_is_begun_at_once(cache: Path) -> None:
    """The build for functions first; that for pictures does not wait for the other size."""
    with Libraries(read_submission(REFERENCE), sizes.DRAWN, cache) as libraries:
        assert targets(libraries) == [UNIT, PLAIN, DRAWN]


def test_a_lazy_one_makes_what_is_asked_for(cache: Path) -> None:
    """One exercise's checks need not wait for pictures, nor for TP1's other size."""
    with Libraries(read_submission(REFERENCE), sizes.DRAWN, cache, lazy=True) as libraries:
        assert targets(libraries) == [UNIT]
        libraries.prepare_plain(pictures=False)
        assert targets(libraries) == [UNIT]
        libraries.prepare_plain(pictures=True)
        assert targets(libraries) == [UNIT, PLAIN]


@pytest.mark.parametrize("written", [True, False])
def test_what_counts_is_made_for_who_has_written_it(cache: Path, written: bool) -> None:
    """It serves one bonus, which few have touched; and it can be made without the others."""
    submission = read_submission(REFERENCE if written else CORE)
    assert (submission.files["octree.c"] == originals.from_core()["octree.c"]) is not written
    with Libraries(submission, sizes.sizes_for(4), cache, lazy=True) as libraries:
        libraries.prepare_counted("octree.c")
        assert any(each.counted for each in libraries._begun) is written
        assert targets(libraries) == [UNIT]
