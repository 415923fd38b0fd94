"""Grading submissions made here, such as a mistake or a variant, as a person's would be."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from grader.build import toolchain
from grader.checking.expected_data import FOLDER
from grader.course import exercises
from grader.course.sizes import sizes_for
from grader.course.texts import Texts
from grader.evaluation.pipeline import report_of, run_checks
from grader.evaluation.records import CheckResult, Finding, Report
from grader.execution.libraries import Libraries
from grader.intake.records import Submission
from grader.report import results as report


def exercise_findings(
    submission: Submission, exercise: str, cache: Path, folder: Path = FOLDER
) -> list[Finding]:
    """Run the checks of one exercise but its pictures, on the expected data of a folder."""
    rules = exercises.load()
    chosen = rules.exercise(exercise)
    ids = [each.id for each in chosen.checks if not each.is_picture]
    with Libraries(submission, sizes_for(chosen.tp), cache) as libraries:
        findings = run_checks(libraries, rules, chosen.tp, ids, folder)
    return [each for each in findings if rules.checks()[each.check].exercise == exercise]


def graded(
    submission: Submission,
    cache: Path,
    tp: int | None = None,
    flags: Sequence[str] = (),
    compiler: str = "",
) -> list[CheckResult]:
    """Run the checks of a TP (None: of all); `flags` and `compiler` build it in another way."""
    return list(_report(submission, cache, tp, flags, compiler).checks)


def results(
    submission: Submission,
    cache: Path,
    flags: Sequence[str] = (),
    compiler: str = "",
    *,
    with_reference: bool = True,
    inputs: Path = FOLDER,
) -> dict[str, Any]:
    """Return the content of results.json, but for what changes from one run to the next.

    `inputs` is a folder of expected data.
    """
    judged = _report(submission, cache, None, flags, compiler, with_reference, inputs)
    content = report.as_json(judged, Texts("en"))
    pictures = {
        report.image_name(each, role): hashlib.sha256(content).hexdigest()
        for each in judged.checks
        for role, content in each.images.items()
    }
    checks = [{**each, "seconds": 0} for each in content["checks"]]
    return {**content, "graded_at": "", "checks": checks, "pictures": pictures}


def _report(
    submission: Submission,
    cache: Path,
    tp: int | None,
    flags: Sequence[str],
    compiler: str,
    with_reference: bool = True,
    inputs: Path = FOLDER,
) -> Report:
    rules = exercises.load()
    chosen = toolchain.find_compiler(compiler)
    with Libraries(submission, sizes_for(tp), cache, chosen, tuple(flags)) as libraries:
        findings = run_checks(libraries, rules, tp, None, inputs, with_reference=with_reference)
        return report_of(libraries, rules, findings, Texts("en"))


def lost(checks: Sequence[CheckResult]) -> list[CheckResult]:
    """Return the checks that did not get all their points."""
    return [each for each in checks if each.points < each.max_points]
