"""From a submission to its report, the same for one and for a class; each step is a function.

run: pytest runs the checks, and each becomes a finding
attribute: what another exercise may have spoilt is run again among the reference's functions
with_worst_pixels: of a wrong picture, the first value that goes wrong in its worst pixel
with_mistakes: the known mistakes that give just these wrong answers
grade: points and sentences
"""

from __future__ import annotations

import time
from collections.abc import Collection, Sequence
from pathlib import Path

from grader.checking.expected_data import FOLDER, ExpectedError
from grader.checking.student import Student
from grader.course import settings
from grader.course.exercises import Manifest
from grader.course.texts import Texts
from grader.evaluation import plugin, remarks
from grader.evaluation.attribution import attribute
from grader.evaluation.grading import grade
from grader.evaluation.recognition import with_mistakes
from grader.evaluation.records import Finding, Outcome, PytestError, Report
from grader.evaluation.rules import is_learnt, settle
from grader.evaluation.worst_pixel import with_worst_pixel
from grader.execution.libraries import Libraries


def run_checks(
    libraries: Libraries,
    rules: Manifest,
    tp: int | None,
    chosen: Collection[str] | None = None,
    folder: Path = FOLDER,
    *,
    with_reference: bool = True,
    fresh: Path | None = None,
) -> list[Finding]:
    """Run the chosen checks (None: all) of a TP (None: of those that count).

    `folder` is that of the expected data; what fails is not judged again among the reference's
    functions in a student's copy, which has none, nor without `with_reference`. `fresh` is another
    folder of expected data, that students have not: what passes must do so there too. Raises
    PytestError.
    """
    checks = plugin.GraderPlugin(libraries, rules, tp, folder, chosen=chosen, fresh=fresh)
    findings = plugin.run(checks)
    if with_reference:
        findings = attribute(findings, rules, libraries, folder, checks.again)
    findings = with_worst_pixels(findings, rules, libraries, folder)
    try:
        return with_mistakes(findings, rules, folder)
    except ExpectedError as error:
        raise PytestError(str(error)) from error


def with_worst_pixels(
    findings: Sequence[Finding], rules: Manifest, libraries: Libraries, folder: Path
) -> list[Finding]:
    """Return the findings; those on wrong pictures that will be shown tell of their worst pixel."""

    def looked_at(finding: Finding, outcome: Outcome) -> Finding:
        if outcome is not Outcome.FAILED or not finding.evidence.spots or finding.evidence.pinned:
            return finding
        exercise = rules.exercise(rules.checks()[finding.check].exercise)
        student = Student(libraries.lend(exercise.file), folder, exercise.functions)
        return with_worst_pixel(finding, student)

    outcomes = [each.outcome for each in settle(findings, rules).findings]
    return [looked_at(*pair) for pair in zip(findings, outcomes, strict=True)]


def report_of(
    libraries: Libraries,
    rules: Manifest,
    findings: Sequence[Finding],
    texts: Texts,
    hint: int = 1,
    partial: bool = False,
) -> Report:
    """Return the report of a submission whose checks have run."""
    rejected = libraries.rejected
    checks, exercises = grade(findings, rules, texts, hint=hint, rejected=rejected)
    judged = {each.tp for each in rules.exercises if each.checks}
    learnt = {rules.checks()[each.check].exercise for each in findings if is_learnt(each)}
    return Report(
        submission=libraries.submission,
        language=texts.language,
        builds=tuple(libraries.builds),
        checks=tuple(checks),
        exercises=tuple(exercises),
        graded_at=time.time(),
        notes=tuple(remarks.notes(libraries.submission, libraries.builds, libraries.sanitized)),
        rejected=rejected,
        opened=settings.load().opened,
        unjudged=tuple(sorted(set(rules.tps) - judged)),
        partial=partial,
        learnt=tuple(each.id for each in rules.exercises if each.id in learnt),
    )
