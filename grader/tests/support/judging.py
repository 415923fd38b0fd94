"""Judging a submission within a test, without the command line."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path

from grader.course import exercises as manifest
from grader.course.sizes import sizes_for
from grader.course.texts import Texts
from grader.evaluation.grading import conclude
from grader.evaluation.plugin import run_checks
from grader.execution.libraries import Workshop
from grader.records import CheckResult, Submission

REFERENCE = manifest.ROOT / "reference"


def solution() -> dict[str, str]:
    """Return the reference's files by their names."""
    names = manifest.load().student
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
    rules = manifest.load()
    if chosen is None:
        words = keyword.split(" or ")
        chosen = [name for name in rules.checks() if any(word in name for word in words)]
    content = {name: text.encode() for name, text in files.items()}
    submission = Submission("rendu", content, missing=())
    with Workshop(submission, sizes_for(tp), cache) as workshop:
        findings = run_checks(workshop, rules, tp, chosen)
        checks, _ = conclude(findings, rules, Texts("en"), rejected=workshop.rejected)
    return {each.id: each for each in checks}
