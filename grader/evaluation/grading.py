"""From what the checks found to points: the rules on markers, twins and exercises."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, replace

from grader.checking import clues, reproducer
from grader.course.exercises import Check, Exercise, Manifest
from grader.course.texts import Texts
from grader.evaluation.records import CheckResult, ExerciseResult, Finding, Outcome, Pixel
from grader.evaluation.rules import DONE_WRONG, Settled, is_beside, settle
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
MOST_DIRECT = 3  # the last level of help
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
    telling = _Telling(rules, texts, hint, rejected, settled)
    checks = [_judge(each, rules, outcomes, telling) for each in settled.findings]
    checks = _without_lone_pictures(checks, rules, texts)
    exercises = [_sum(each, checks, texts.language) for each in rules.exercises]
    return checks, [each for each in exercises if each is not None]


@dataclass(frozen=True)
class _Telling:
    """What sentences are made with."""

    rules: Manifest
    texts: Texts
    hint: int
    rejected: Container[str]
    settled: Settled

    def help(self, finding: Finding) -> str:
        """Return a question, or the hint of the level, the last that there is.

        They are those of the mistake that is recognised, which the last level names; then those of
        how the code ended, if it did not come back, or of what is wrong and how; of the check
        otherwise.
        """
        if known := self._mistakes(finding.evidence.mistakes):
            return known
        if asked := death_messages.question(finding.message, self.texts, self.hint):
            return asked
        if asked := clues.question(finding.message, finding.check, self.texts, self.hint):
            return asked
        found = self.texts.get(f"question.{finding.check}")
        for level in range(2, self.hint + 1):
            found = self.texts.get(f"hint.{finding.check}.{level}", found)
        return found

    def further(self, finding: Finding) -> dict[int, str]:
        """Return what the next levels of help say, by level, where they say something more."""
        told, found = self.help(finding), {}
        for level in range(self.hint + 1, MOST_DIRECT + 1):
            more = replace(self, hint=level).help(finding)
            if more != told:
                found[level] = told = more
        return found

    def _mistakes(self, ids: Sequence[str]) -> str:
        """Return what is told of mistakes that no check tells apart; each sentence once."""
        parts = (("question",), ("hint",), ("title", "hint"))[self.hint - 1]
        told = (
            " ".join(filter(None, (self.texts.get(f"mistake.{name}.{part}") for part in parts)))
            for name in ids
        )
        return self.texts.say("note.or").join(dict.fromkeys(filter(None, told)))

    def note(self, finding: Finding, exercise: Exercise, outcome: Outcome) -> str:
        """Return what to know besides."""
        remarks = [self.texts.say(each.key, **each.values) for each in finding.remarks]
        return " ".join(filter(None, [self._marker(finding, exercise, outcome), *remarks]))

    def waits_for(self, check: Check, outcome: Outcome) -> tuple[str, ...]:
        """Return the exercises to look at before a check that waits, itself or with its twin."""
        if outcome is not Outcome.BLOCKED:
            return ()
        waits = self.settled.waits
        return waits.get(check.id) or waits.get(check.twin, ())

    def _marker(self, finding: Finding, exercise: Exercise, outcome: Outcome) -> str:
        """Say that a marker was left, where the fault lies, or what must be done first."""
        if outcome is Outcome.PASSED and exercise.id in finding.todo:
            return self.texts.say("note.marker", id=exercise.id, file=exercise.file)
        if outcome is Outcome.PASSED and finding.through:
            return self.texts.say("note.through", ids=", ".join(finding.through))
        first = self.waits_for(self.rules.checks()[finding.check], outcome)
        if not first:
            return ""
        files = {self.rules.exercise(name).file for name in first}
        broken = sorted(file for file in files if file in self.rejected)
        if broken:
            return self.texts.say("note.blocked_by_file", files=", ".join(broken))
        missing = [each for each in first if each in self.settled.unwritten or each in finding.todo]
        key = "note.blocked" if missing else "note.waits"
        return self.texts.say(key, ids=", ".join(missing or first))


def _judge(
    finding: Finding, rules: Manifest, outcomes: Mapping[str, Outcome], telling: _Telling
) -> CheckResult:
    texts = telling.texts
    check = rules.checks()[finding.check]
    exercise = rules.exercise(check.exercise)
    outcome, message = finding.outcome, ""
    if finding.message is not None:
        message = death_messages.told(finding.message, finding.location, texts)
    if outcome is Outcome.PASSED and outcomes.get(check.twin, outcome) is not Outcome.PASSED:
        # A refusal is worth something only from a function that does the other thing as well.
        outcome = Outcome.TODO if outcomes[check.twin] is Outcome.TODO else Outcome.BLOCKED
        message = texts.say("failure.twin")
    passed = outcome is Outcome.PASSED
    is_asked = outcome in _ASKED and not is_beside(finding)
    share = finding.evidence.share if outcome is Outcome.FAILED else 0.0
    return CheckResult(
        id=check.id,
        exercise=exercise.id,
        tp=exercise.tp,
        function=check.function,
        title=texts.get(f"title.{check.id}", finding.title),
        outcome=outcome,
        waits_for=telling.waits_for(check, outcome),
        points=check.points if passed else round(share * check.points),
        max_points=check.points,
        message=message,
        hint=telling.help(finding) if is_asked else "",
        hints=telling.further(finding) if is_asked else {},
        note=telling.note(finding, exercise, outcome),
        location=finding.location,
        output=finding.output if outcome in DONE_WRONG else "",
        seconds=finding.seconds,
        mistakes=finding.evidence.mistakes,
        reproducer=reproducer.told(finding.evidence.reproducer, texts),
        images=finding.evidence.images,
        places=_places(finding, texts),
        pixel=_pixel(finding, texts) if outcome is Outcome.FAILED else None,
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
        message = texts.say("failure.lone_picture", function=each.function)
        return replace(each, outcome=outcome, points=0, message=message)

    return [judged(each) for each in checks]


def _pixel(finding: Finding, texts: Texts) -> Pixel | None:
    """Return the pixel to look at, with its sentence."""
    found = finding.evidence.pinned
    if found is None:
        return None
    told = texts.say("replay.worst", i=found.i, j=found.j)
    if found.told is not None:
        told = f"{told} {death_messages.told(found.told, found.location, texts)}"
    return Pixel(found.picture, found.i, found.j, told)


def _places(finding: Finding, texts: Texts) -> str:
    """Return where a picture is wrong, in words."""
    found = finding.evidence.places
    return texts.say(found.key, **found.values) if found else ""


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
