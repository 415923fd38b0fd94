"""From a submission's findings to its report: the same for one submission and for a class."""

from __future__ import annotations

import time
from collections.abc import Sequence

from grader.course import settings
from grader.course.exercises import Manifest
from grader.course.texts import Texts
from grader.evaluation import remarks
from grader.evaluation.grading import grade
from grader.evaluation.records import Finding, Report
from grader.execution.libraries import Libraries


def report_of(
    libraries: Libraries,
    rules: Manifest,
    findings: Sequence[Finding],
    texts: Texts,
    hint: int = 1,
    partial: bool = False,
) -> Report:
    """Return the report of a submission whose checks have run."""
    rejected = {
        name: texts.say(message.key, **message.values)
        for name, message in libraries.rejected.items()
    }
    checks, exercises = grade(findings, rules, texts, hint=hint, rejected=rejected)
    judged = {each.tp for each in rules.exercises if each.checks}
    return Report(
        submission=libraries.submission,
        language=texts.language,
        builds=tuple(libraries.builds),
        checks=tuple(checks),
        exercises=tuple(exercises),
        graded_at=time.time(),
        notes=tuple(
            remarks.notes(libraries.submission, libraries.builds, libraries.sanitized, texts)
        ),
        rejected=rejected,
        opened=settings.load().opened,
        unjudged=tuple(sorted(set(rules.tps) - judged)),
        partial=partial,
    )
