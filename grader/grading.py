"""From what the checks found to points: the rules on markers, twins and exercises."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from grader.manifest import Check, Exercise, Manifest
from grader.records import CheckResult, ExerciseResult, Finding, Outcome
from grader.texts import Texts

# An exercise is as good as its worst check; the first of these that occurs names it.
_WORST_FIRST = (
    Outcome.ERROR,
    Outcome.CRASHED,
    Outcome.TIMEOUT,
    Outcome.FAILED,
    Outcome.BLOCKED,
    Outcome.TODO,
    Outcome.PASSED,
)


def conclude(
    findings: Sequence[Finding], rules: Manifest, texts: Texts
) -> tuple[list[CheckResult], list[ExerciseResult]]:
    """Apply the rules; return the checks in the findings' order, and their exercises."""
    marked = [_with_markers(each, rules.checks()[each.check]) for each in findings]
    outcomes = {each.check: each.outcome for each in marked}
    checks = [_judge(each, rules, outcomes, texts) for each in marked]
    exercises = [_sum(each, checks, texts.language) for each in rules.exercises]
    return checks, [each for each in exercises if each is not None]


def _with_markers(finding: Finding, check: Check) -> Finding:
    """Make a wrong answer `todo` by the exercise's own marker, `blocked` by another's."""
    if finding.outcome in (Outcome.PASSED, Outcome.ERROR) or not finding.todo:
        return finding
    own = check.exercise in finding.todo
    return replace(finding, outcome=Outcome.TODO if own else Outcome.BLOCKED)


def _judge(
    finding: Finding, rules: Manifest, outcomes: Mapping[str, Outcome], texts: Texts
) -> CheckResult:
    check = rules.checks()[finding.check]
    exercise = rules.exercise(check.exercise)
    outcome, message = finding.outcome, ""
    if finding.verdict is not None:
        place = texts.say("death.place", location=finding.location) if finding.location else ""
        message = texts.say(finding.verdict.key, place=place, **finding.verdict.values)
    if outcome is Outcome.PASSED and outcomes.get(check.twin, outcome) is not Outcome.PASSED:
        # A refusal is worth something only from a function that does the other thing as well.
        twin = outcomes[check.twin]
        outcome = twin if twin in (Outcome.TODO, Outcome.BLOCKED) else Outcome.FAILED
        message = texts.say("failure.twin")
    passed = outcome is Outcome.PASSED
    return CheckResult(
        id=check.id,
        exercise=exercise.id,
        tp=exercise.tp,
        function=exercise.functions[0],
        title=texts.get(f"title.{check.id}", finding.title),
        outcome=outcome,
        points=check.points if passed else 0,
        max_points=check.points,
        message=message,
        hint="" if passed else texts.get(f"question.{check.id}"),
        note=_note(finding, exercise, outcome, texts),
        location=finding.location,
        seconds=finding.seconds,
    )


def _note(finding: Finding, exercise: Exercise, outcome: Outcome, texts: Texts) -> str:
    if outcome is Outcome.PASSED and exercise.id in finding.todo:
        return texts.say("note.marker", id=exercise.id, file=exercise.file)
    if outcome is Outcome.BLOCKED:
        return texts.say("note.blocked", ids=", ".join(sorted(finding.todo)))
    return ""


def _sum(exercise: Exercise, checks: Sequence[CheckResult], language: str) -> ExerciseResult | None:
    """Return the exercise's sum; None when none of its checks has run."""
    own = [each for each in checks if each.exercise == exercise.id]
    if not own:
        return None
    outcomes = {each.outcome for each in own}
    return ExerciseResult(
        id=exercise.id,
        tp=exercise.tp,
        function=exercise.functions[0],
        file=exercise.file,
        title=exercise.titles[language],
        bonus=exercise.bonus,
        outcome=next(each for each in _WORST_FIRST if each in outcomes),
        points=sum(each.points for each in own),
        max_points=sum(each.max_points for each in own),
    )
