"""From a submission's findings to its report: the same for one submission and for a class."""

from __future__ import annotations

import time
from collections.abc import Sequence

from grader.course import settings as course
from grader.course.exercises import Manifest
from grader.course.texts import Texts
from grader.evaluation import remarks as notes
from grader.evaluation.grading import conclude
from grader.execution.libraries import Workshop
from grader.records import Finding, Report


def report_of(
    workshop: Workshop,
    rules: Manifest,
    findings: Sequence[Finding],
    texts: Texts,
    hint: int = 1,
    partial: bool = False,
) -> Report:
    """Return the report of a submission whose checks have run."""
    rejected = {
        name: texts.say(verdict.key, **verdict.values)
        for name, verdict in workshop.rejected.items()
    }
    checks, exercises = conclude(findings, rules, texts, hint=hint, rejected=rejected)
    judged = {each.tp for each in rules.exercises if each.checks}
    return Report(
        submission=workshop.submission,
        language=texts.language,
        builds=tuple(workshop.builds),
        checks=tuple(checks),
        exercises=tuple(exercises),
        graded_at=time.time(),
        notes=tuple(notes.notes(workshop.submission, workshop.builds, workshop.sanitized, texts)),
        rejected=rejected,
        opened=course.load().opened,
        unjudged=tuple(sorted(set(rules.tps) - judged)),
        partial=partial,
    )
