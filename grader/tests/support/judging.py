"""Judging a submission within a test, without the command line."""

from __future__ import annotations

from collections.abc import Mapping
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
    files: Mapping[str, str], cache: Path, tp: int | None = None, keyword: str = ""
) -> dict[str, CheckResult]:
    """Run the checks of a TP whose names match pytest's keyword; return them by their ids."""
    rules = manifest.load()
    content = {name: text.encode() for name, text in files.items()}
    submission = Submission("rendu", content, missing=())
    with Workshop(submission, sizes_for(tp), cache) as workshop:
        findings = run_checks(workshop, rules, tp, keyword)
        checks, _ = conclude(findings, rules, Texts("en"), rejected=workshop.rejected)
    return {each.id: each for each in checks}
