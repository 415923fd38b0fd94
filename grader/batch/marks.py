"""From points to a mark: weights, scale, bonus, rubric, lateness, rounding. Reads JSON only."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from grader.batch.contents import some
from grader.batch.lateness import Lateness
from grader.batch.names import is_named
from grader.batch.records import BatchError, Graded, ManualMark, Mark, Member
from grader.course import exercises
from grader.course.message import Message
from grader.course.settings import Course
from grader.evaluation.records import Outcome


def points(results: Mapping[str, Any], course: Course) -> tuple[float, float]:
    """Return the mark without its bonus, and what the bonus adds, in units of the scale."""
    marks = course.marks
    total = weight = 0.0
    for tp in results["tps"]:
        own = marks.weights.get(tp["tp"], tp["max_score"])
        weight += own
        total += own * tp["score"] / tp["max_score"] if tp["max_score"] else 0.0
    base = marks.scale * total / weight if weight else 0.0
    whole = exercises.load().total(bonus=False)  # bonus points count as parts of it
    return base, min(marks.bonus_cap, marks.scale * results["bonus"] / whole)


def rounded(value: float, course: Course) -> float:
    """Return a mark as a multiple of the step, a half upwards, between 0 and the scale."""
    step = Fraction(str(course.marks.step)) or Fraction(1, 100)
    # 12.124999999 is 12.125 that a sum of floats has missed.
    exact = Fraction(round(value, 9)).limit_denominator(10**9)
    multiple = math.floor(exact / step + Fraction(1, 2)) * step
    return float(min(max(multiple, Fraction(0)), Fraction(str(course.marks.scale))))


def mark(
    member: Member,
    graded: Graded | None,
    hand: ManualMark | None,
    lateness: Lateness,
    course: Course,
) -> Mark:
    """Return a person's mark; where there is none, why."""
    why = list(member.remarks)
    if graded and graded.candidate.remarks:
        why += graded.candidate.remarks
    given = Mark(member, None, comment=hand.comment if hand else "", why=tuple(why))
    if hand and hand.override is not None:
        why += [*_problem(graded), Message("batch.overridden", {"reason": hand.reason})]
        return _with(given, value=rounded(hand.override, course), why=why)
    if any(is_named(member, each) for each in course.people.excused):
        return _with(given, why=[*why, Message("batch.excused")])
    if member.unsettled:
        return given
    if graded is None:
        return _with(given, value=course.people.absent, why=why)
    return _of_submission(given, graded, hand, lateness, course)


def _of_submission(
    given: Mark, graded: Graded, hand: ManualMark | None, lateness: Lateness, course: Course
) -> Mark:
    """Return the mark of who has a submission of their own."""
    if problem := _problem(graded):
        return _with(given, why=[*given.why, *problem])
    if graded.results is None or (graded.results["incomplete"] and not graded.settled):
        detail = graded.failure or Message("batch.incomplete")
        told = Message("batch.failed", {"detail": detail})
        return _with(given, why=[*given.why, told], error=True)
    if lateness.unknown:
        return _with(given, why=[*given.why, *lateness.remarks])
    if graded.settled:
        given = _with(given, why=[*given.why, _settled(graded.results)])
    return _counted(given, graded.results, hand, lateness, course)


def _settled(results: Mapping[str, Any]) -> Message:
    """Return what counts as failed although it could not be judged."""
    lost = [name for name, outcome in results["checks"].items() if outcome == Outcome.ERROR.value]
    return Message("batch.settled", {"checks": some(lost)})


def _problem(graded: Graded | None) -> tuple[Message, ...]:
    """Return why there was nothing to grade; nothing when there was."""
    return (graded.candidate.problem,) if graded and graded.candidate.problem else ()


def _counted(
    given: Mark,
    results: Mapping[str, Any],
    hand: ManualMark | None,
    lateness: Lateness,
    course: Course,
) -> Mark:
    base, bonus = points(results, course)
    rubric = sum(hand.rubric.values()) if hand else 0.0
    late, days = course.late, lateness.days
    penalty = min(late.most, late.per_day * days)
    # The scale is the most before lateness too: a late day costs everybody the same.
    before = min(course.marks.scale, base + bonus + rubric)
    value = before - penalty
    why = [*given.why, *lateness.remarks, *_broken(results), *_learnt(results)]
    if late.zero_after_days and days > late.zero_after_days:
        penalty, value = before, 0.0
    told = Message("batch.late", {"days": days, "penalty": float(penalty)}) if days else None
    value = rounded(value, course)
    if value == 0:
        why.append(_zero(results, rubric))
    return _with(
        given,
        value=value,
        points=base,
        bonus=bonus,
        rubric=rubric,
        late_days=days,
        penalty=penalty,
        late=told,
        why=[*why, told] if told else why,
    )


def _broken(results: Mapping[str, Any]) -> list[Message]:
    """Return what keeps a submission from being judged whole."""
    if results["compiles"]:
        return []
    names = ", ".join(results["rejected"])
    return [
        Message("batch.not_compiled", {"names": names}) if names else Message("batch.not_built")
    ]


def _learnt(results: Mapping[str, Any]) -> list[Message]:
    """Return what is right on the inputs of the archive, and wrong on others."""
    names = ", ".join(results["learnt"])
    return [Message("batch.learnt", {"ids": names})] if names else []


def _zero(results: Mapping[str, Any], rubric: float) -> Message:
    """Return why a mark is 0: what became of the exercises."""
    outcomes = Counter(row[0] for row in results["exercises"].values())
    counts: dict[str, object] = {
        "right": outcomes[Outcome.PASSED.value],
        "wrong": outcomes[Outcome.FAILED.value],
        "broken": outcomes[Outcome.CRASHED.value] + outcomes[Outcome.TIMEOUT.value],
        "todo": outcomes[Outcome.TODO.value] + outcomes[Outcome.BLOCKED.value],
    }
    if rubric < 0:
        return Message("batch.zero_rubric", {**counts, "rubric": float(rubric)})
    return Message("batch.zero", counts)


def _with(given: Mark, **changes: Any) -> Mark:
    changes["why"] = tuple(changes.get("why", given.why))
    return Mark(**{**given.__dict__, **changes})


def verify_people(course: Course, members: Sequence[Member]) -> None:
    """Raise BatchError when a setting names nobody of the class, or several.

    A slip of the pen costs marks.
    """
    for name in dict.fromkeys((*course.people.excused, *course.people.extensions)):
        found = [each for each in members if is_named(each, name)]
        if not found:
            raise BatchError("batch.course_nobody", name=name)
        if len(found) > 1:
            raise BatchError("batch.course_several", name=name)
