"""From what the checks found to points: the rules on markers, twins and exercises."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, replace

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
# The function was never judged: its question would lead astray.
_BESIDE = (
    *("failure.missing", "failure.not_built", "failure.not_linked", "failure.unreadable"),
    *("failure.error", "death.missing_symbol"),
)


def conclude(
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
    marked = [_with_markers(each, rules.checks()[each.check]) for each in findings]
    outcomes = {each.check: each.outcome for each in marked}
    telling = _Telling(rules, texts, hint, rejected)
    checks = [_judge(each, rules, outcomes, telling) for each in marked]
    exercises = [_sum(each, checks, texts.language) for each in rules.exercises]
    return checks, [each for each in exercises if each is not None]


@dataclass(frozen=True)
class _Telling:
    """What sentences are made with."""

    rules: Manifest
    texts: Texts
    hint: int
    rejected: Container[str]

    def help(self, check: str) -> str:
        """Return the question of a check, or its hint of the level, the last that it has."""
        found = self.texts.get(f"question.{check}")
        for level in range(2, self.hint + 1):
            found = self.texts.get(f"hint.{check}.{level}", found)
        return found

    def note(self, finding: Finding, exercise: Exercise, outcome: Outcome) -> str:
        """Return what to know besides."""
        remarks = [self.texts.say(each.key, **each.values) for each in finding.remarks]
        return " ".join(filter(None, [self._marker(finding, exercise, outcome), *remarks]))

    def _marker(self, finding: Finding, exercise: Exercise, outcome: Outcome) -> str:
        """Say that a marker was left, or what must be done first."""
        if outcome is Outcome.PASSED and exercise.id in finding.todo:
            return self.texts.say("note.marker", id=exercise.id, file=exercise.file)
        if outcome is not Outcome.BLOCKED:
            return ""
        files = {self.rules.exercise(name).file for name in finding.todo}
        broken = sorted(file for file in files if file in self.rejected)
        if broken:
            return self.texts.say("note.blocked_by_file", files=", ".join(broken))
        return self.texts.say("note.blocked", ids=", ".join(sorted(finding.todo)))


def _is_beside(finding: Finding) -> bool:
    """Whether what is wrong has nothing to do with what the check's question is about."""
    return finding.verdict is not None and finding.verdict.key in _BESIDE


def _with_markers(finding: Finding, check: Check) -> Finding:
    """Make a wrong answer `todo` by the exercise's own marker, `blocked` by another's."""
    if finding.outcome in (Outcome.PASSED, Outcome.ERROR) or not finding.todo:
        return finding
    own = check.exercise in finding.todo
    return replace(finding, outcome=Outcome.TODO if own else Outcome.BLOCKED)


def _place(finding: Finding, texts: Texts) -> str:
    """Return where the code was when it died, as the end of a sentence; "" when not known."""
    function = finding.verdict.values.get("function") if finding.verdict else ""
    if not finding.location:
        return ""
    key = "death.place_in" if function else "death.place"
    return texts.say(key, location=finding.location, function=function)


def _judge(
    finding: Finding, rules: Manifest, outcomes: Mapping[str, Outcome], telling: _Telling
) -> CheckResult:
    texts = telling.texts
    check = rules.checks()[finding.check]
    exercise = rules.exercise(check.exercise)
    outcome, message = finding.outcome, ""
    if finding.verdict is not None:
        values = {"place": _place(finding, texts), **finding.verdict.values}
        if values.get("call") == "":
            values["call"] = texts.say("death.loading")
        message = texts.say(finding.verdict.key, **values)
    if outcome is Outcome.PASSED and outcomes.get(check.twin, outcome) is not Outcome.PASSED:
        # A refusal is worth something only from a function that does the other thing as well.
        twin = outcomes[check.twin]
        outcome = twin if twin in (Outcome.TODO, Outcome.BLOCKED) else Outcome.FAILED
        message = texts.say("failure.twin")
    passed = outcome is Outcome.PASSED
    share = finding.evidence.share if outcome is Outcome.FAILED else 0.0
    return CheckResult(
        id=check.id,
        exercise=exercise.id,
        tp=exercise.tp,
        function=exercise.functions[0],
        title=texts.get(f"title.{check.id}", finding.title),
        outcome=outcome,
        points=check.points if passed else round(share * check.points),
        max_points=check.points,
        message=message,
        hint="" if passed or _is_beside(finding) else telling.help(check.id),
        note=telling.note(finding, exercise, outcome),
        location=finding.location,
        output=finding.output if outcome in (Outcome.FAILED, Outcome.TIMEOUT) else "",
        seconds=finding.seconds,
        mistakes=finding.evidence.mistakes,
        reproducer=finding.evidence.reproducer,
        images=finding.evidence.images,
    )


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
