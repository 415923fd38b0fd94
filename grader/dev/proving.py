"""Grading submissions made here, such as a mistake or a variant, as a person's would be."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from grader import manifest, toolchain
from grader.expected import FOLDER
from grader.grading import conclude
from grader.judge import sizes_for
from grader.plugin import run_checks
from grader.records import CheckResult, Finding, Submission
from grader.texts import Texts
from grader.workshop import Workshop


def exercise_findings(
    submission: Submission, exercise: str, cache: Path, folder: Path = FOLDER
) -> list[Finding]:
    """Run the checks of one exercise but its pictures, on the expected data of a folder."""
    rules = manifest.load()
    chosen = rules.exercise(exercise)
    ids = [each.id.partition(".")[2] for each in chosen.checks]
    names = [f"test_{each.replace('.', '_')}" for each in ids if not each.startswith("scene.")]
    with Workshop(submission, sizes_for(chosen.tp), cache) as workshop:
        findings = run_checks(workshop, rules, chosen.tp, " or ".join(names), folder)
    return [each for each in findings if rules.checks()[each.check].exercise == exercise]


def graded(
    submission: Submission,
    cache: Path,
    tp: int | None = None,
    flags: Sequence[str] = (),
    compiler: str = "",
) -> list[CheckResult]:
    """Run the checks of a TP (None: of all); `flags` and `compiler` build it in another way."""
    rules = manifest.load()
    chosen = toolchain.find_compiler(compiler)
    with Workshop(submission, sizes_for(tp), cache, chosen, tuple(flags)) as workshop:
        findings = run_checks(workshop, rules, tp, "")
        checks, _ = conclude(findings, rules, Texts("en"), rejected=workshop.rejected)
    return checks


def lost(checks: Sequence[CheckResult]) -> list[CheckResult]:
    """Return the checks that did not get all their points."""
    return [each for each in checks if each.points < each.max_points]
