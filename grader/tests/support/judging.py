"""Judging a submission within a test, without the command line."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path

from grader.course import exercises
from grader.course.sizes import sizes_for
from grader.course.texts import Texts
from grader.evaluation.grading import grade
from grader.evaluation.pipeline import run_checks
from grader.evaluation.records import CheckResult
from grader.execution.libraries import Libraries
from grader.intake.records import Submission

REFERENCE = exercises.ROOT / "reference"


def solution() -> dict[str, str]:
    """Return the reference's files by their names."""
    names = exercises.load().student
    return {name: (REFERENCE / name).read_text(encoding="utf-8") for name in names}


def judge(
    files: Mapping[str, str],
    cache: Path,
    tp: int | None = None,
    keyword: str = "",
    chosen: Collection[str] | None = None,
) -> dict[str, CheckResult]:
    """Run the chosen checks of a TP, or those whose ids hold a word; return them by their ids.

    Words are parted by " or ".
    """
    rules = exercises.load()
    if chosen is None:
        words = keyword.split(" or ")
        chosen = [name for name in rules.checks() if any(word in name for word in words)]
    content = {name: text.encode() for name, text in files.items()}
    submission = Submission("rendu", content, missing=())
    with Libraries(submission, sizes_for(tp), cache) as libraries:
        findings = run_checks(libraries, rules, tp, chosen)
        checks, _ = grade(findings, rules, Texts("en"), rejected=libraries.rejected)
    return {each.id: each for each in checks}
