"""From what the checks found to points: the rules on markers, twins and exercises."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from grader.checking import reproducer
from grader.checking.records import Pinned
from grader.course.exercises import Check, Exercise, Manifest
from grader.course.message import Message
from grader.course.texts import Texts
from grader.evaluation.records import CheckResult, ExerciseResult, Finding, Outcome, Pixel, Words
from grader.evaluation.rules import DONE_WRONG, Settled, is_beside, settle
from grader.evaluation.wording import Wording
from grader.execution import death_messages

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
_ASKED = (*DONE_WRONG, Outcome.TODO)  # what a question is asked about


def grade(
    findings: Sequence[Finding],
    rules: Manifest,
    texts: Texts,
    hint: int = 1,
    rejected: Container[str] = (),
) -> tuple[list[CheckResult], list[ExerciseResult]]:
    """Apply the rules; return the checks in the findings' order, and their exercises.

    `hint` is the level of help, from a question (1) to the most direct (3); `rejected` are the
    files that do not compile.
    """
    settled = settle(findings, rules)
    outcomes = {each.check: each.outcome for each in settled.findings}
    telling = _Telling(rules, rejected, settled)
    checks = [_judge(each, rules, outcomes, telling, texts, hint) for each in settled.findings]
    checks = _without_lone_pictures(checks, rules, texts)
    exercises = [_sum(each, checks, texts) for each in rules.exercises]
    return checks, [each for each in exercises if each is not None]


@dataclass(frozen=True)
class _Telling:
    """What there is to know of a check besides, and for what it waits."""

    rules: Manifest
    rejected: Container[str]
    settled: Settled

    def notes(self, finding: Finding, exercise: Exercise, outcome: Outcome) -> Iterator[Message]:
        """Yield what to know besides."""
        yield from self._marker(finding, exercise, outcome)
        yield from finding.remarks

    def waits_for(self, check: Check, outcome: Outcome) -> tuple[str, ...]:
        """Return the exercises to look at before a check that waits, itself or with its twin."""
        if outcome is not Outcome.BLOCKED:
            return ()
        waits = self.settled.waits
        return waits.get(check.id) or waits.get(check.twin, ())

    def _marker(self, finding: Finding, exercise: Exercise, outcome: Outcome) -> Iterator[Message]:
        """Say that a marker was left, where the fault lies, or what must be done first."""
        if outcome is Outcome.PASSED and exercise.id in finding.todo:
            yield Message("note.marker", {"id": exercise.id, "file": exercise.file})
        elif outcome is Outcome.PASSED and finding.through:
            yield Message("note.through", {"ids": ", ".join(finding.through)})
        elif first := self.waits_for(self.rules.checks()[finding.check], outcome):
            yield self._waiting(finding, first)

    def _waiting(self, finding: Finding, first: Sequence[str]) -> Message:
        files = {self.rules.exercise(name).file for name in first}
        broken = sorted(file for file in files if file in self.rejected)
        if broken:
            return Message("note.blocked_by_file", {"files": ", ".join(broken)})
        missing = [each for each in first if each in self.settled.unwritten or each in finding.todo]
        key = "note.blocked" if missing else "note.waits"
        return Message(key, {"ids": ", ".join(missing or first)})


def _judge(
    finding: Finding,
    rules: Manifest,
    outcomes: Mapping[str, Outcome],
    telling: _Telling,
    texts: Texts,
    hint: int,
) -> CheckResult:
    check = rules.checks()[finding.check]
    exercise = rules.exercise(check.exercise)
    outcome, message = finding.outcome, finding.message
    if message is not None:
        message = death_messages.placed(message, finding.location)
    if outcome is Outcome.PASSED and outcomes.get(check.twin, outcome) is not Outcome.PASSED:
        # A refusal is worth something only from a function that does the other thing as well.
        outcome = Outcome.TODO if outcomes[check.twin] is Outcome.TODO else Outcome.BLOCKED
        message = Message("failure.twin")
    passed = outcome is Outcome.PASSED
    is_asked = outcome in _ASKED and not is_beside(finding)
    share = finding.evidence.share if outcome is Outcome.FAILED else 0.0
    pinned = finding.evidence.pinned if outcome is Outcome.FAILED else None
    words = Words(
        finding.title,
        message,
        hint if is_asked else 0,
        tuple(telling.notes(finding, exercise, outcome)),
        finding.evidence.places,
        _on_pixel(pinned) if pinned else None,
    )
    told = Wording(check.id, finding.evidence.mistakes, words, texts)
    return CheckResult(
        id=check.id,
        exercise=exercise.id,
        tp=exercise.tp,
        function=check.function,
        title=told.title(),
        outcome=outcome,
        waits_for=telling.waits_for(check, outcome),
        points=check.points if passed else round(share * check.points),
        max_points=check.points,
        message=told.message(),
        hint=told.hint(),
        hints=told.hints(),
        note=told.note(),
        location=finding.location,
        output=finding.output if outcome in DONE_WRONG else "",
        seconds=finding.seconds,
        mistakes=finding.evidence.mistakes,
        reproducer=reproducer.told(finding.evidence.reproducer, texts),
        images=finding.evidence.images,
        places=told.places(),
        pixel=Pixel(pinned.picture, pinned.i, pinned.j, told.pixel()) if pinned else None,
        words=words,
    )


def _without_lone_pictures(
    checks: Sequence[CheckResult], rules: Manifest, texts: Texts
) -> list[CheckResult]:
    """Return the checks; a picture earns nothing where no function of its exercise is right.

    So one that is in the program already, or that the given functions draw, is worth nothing. Where
    no check of the functions was asked for, pictures count as they are.
    """

    def is_picture(each: CheckResult) -> bool:
        return rules.checks()[each.id].is_picture

    own: dict[str, set[Outcome]] = {}
    for each in checks:
        if not is_picture(each):
            own.setdefault(each.exercise, set()).add(each.outcome)

    def judged(each: CheckResult) -> CheckResult:
        found = own.get(each.exercise)
        if not is_picture(each) or not found or Outcome.PASSED in found:
            return each
        if each.outcome is not Outcome.PASSED:
            return replace(each, points=0)
        outcome = Outcome.TODO if found == {Outcome.TODO} else Outcome.BLOCKED
        said = Message("failure.lone_picture", {"function": each.function})
        words = replace(each.words, message=said)
        return replace(each, outcome=outcome, points=0, message=texts.told(said), words=words)

    return [judged(each) for each in checks]


def _on_pixel(found: Pinned) -> Message:
    """Return what is told of the pixel to look at."""
    then = (death_messages.placed(found.told, found.location),) if found.told else ()
    return Message("replay.worst", {"i": found.i, "j": found.j}, then)


def _sum(exercise: Exercise, checks: Sequence[CheckResult], texts: Texts) -> ExerciseResult | None:
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
        title=texts.title(exercise),
        bonus=exercise.bonus,
        outcome=next(each for each in _WORST_FIRST if each in outcomes),
        points=sum(each.points for each in own),
        max_points=sum(each.max_points for each in own),
    )
