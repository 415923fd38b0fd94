"""From points to a mark: weights, scale, bonus, rubric, lateness, rounding. Reads JSON only."""

from __future__ import annotations

import math
from collections.abc import Mapping
from datetime import datetime, timedelta
from fractions import Fraction
from typing import Any

from grader.batch.records import BatchError, Graded, ManualMark, Mark, Member
from grader.batch.roster import key_of
from grader.course.message import Message
from grader.course.settings import Course

ALL_BONUS = 100.0  # bonus points are counted as parts of the hundred of the whole course


def points(results: Mapping[str, Any], course: Course) -> tuple[float, float]:
    """Return the mark without its bonus, and what the bonus adds, in units of the scale."""
    marks = course.marks
    total = weight = 0.0
    for tp in results["tps"]:
        own = marks.weights.get(tp["tp"], tp["max_score"])
        weight += own
        total += own * tp["score"] / tp["max_score"] if tp["max_score"] else 0.0
    base = marks.scale * total / weight if weight else 0.0
    return base, min(marks.bonus_cap, marks.scale * results["bonus"] / ALL_BONUS)


def rounded(value: float, course: Course) -> float:
    """Return a mark as a multiple of the step, a half upwards, between 0 and the scale."""
    step = Fraction(str(course.marks.step)) or Fraction(1, 100)
    # 12.124999999 is 12.125 that a sum of floats has missed.
    exact = Fraction(round(value, 9)).limit_denominator(10**9)
    multiple = math.floor(exact / step + Fraction(1, 2)) * step
    return float(min(max(multiple, Fraction(0)), Fraction(str(course.marks.scale))))


def days_late(handed: datetime | None, member: Member, course: Course) -> int:
    """Return the days begun after a person's own deadline; 0 without a date or a deadline."""
    deadline = extension(member, course) or course.deadline
    if handed is None or deadline is None:
        return 0
    late = handed - deadline - timedelta(minutes=course.late.grace_minutes)
    return max(0, math.ceil(late / timedelta(days=1)))


def extension(member: Member, course: Course) -> datetime | None:
    """Return a person's own deadline."""
    for name, moment in course.people.extensions.items():
        if is_named(member, name):
            return moment
    return None


def is_named(member: Member, name: str) -> bool:
    """Say whether a setting of the course is about that person."""
    by_number = member.number != "" and name == member.number
    return by_number or key_of(name) == key_of(member.name)


def mark(
    member: Member,
    graded: Graded | None,
    hand: ManualMark | None,
    handed: datetime | None,
    course: Course,
) -> Mark:
    """Return a person's mark; where there is none, why."""
    why = list(member.remarks)
    if graded and graded.candidate.remarks:
        why += graded.candidate.remarks
    comment = hand.comment if hand else ""
    given = Mark(member, None, comment=comment, why=tuple(why))
    if hand and hand.override is not None:
        why += [*_problem(graded), Message("batch.overridden", {"reason": hand.reason})]
        return _with(given, value=rounded(hand.override, course), why=why)
    if any(is_named(member, each) for each in course.people.excused):
        return _with(given, why=[*why, Message("batch.excused")])
    if graded is None:
        return _with(given, value=course.people.absent, why=why)
    if member.doubled:
        return given
    if problem := _problem(graded):
        return _with(given, why=[*why, *problem])
    if graded.results is None or graded.results["incomplete"]:
        detail = graded.failure or Message("batch.incomplete")
        return _with(given, why=[*why, Message("batch.failed", {"detail": detail})], error=True)
    return _counted(given, graded.results, hand, days_late(handed, member, course), course)


def _problem(graded: Graded | None) -> tuple[Message, ...]:
    """Return why there was nothing to grade; nothing when there was."""
    return (graded.candidate.problem,) if graded and graded.candidate.problem else ()


def _counted(
    given: Mark, results: Mapping[str, Any], hand: ManualMark | None, days: int, course: Course
) -> Mark:
    base, bonus = points(results, course)
    rubric = sum(hand.rubric.values()) if hand else 0.0
    late = course.late
    penalty = min(late.most, late.per_day * days)
    # The scale is the most before lateness too: a late day costs everybody the same.
    value = min(course.marks.scale, base + bonus + rubric) - penalty
    why = list(given.why)
    if late.zero_after_days and days > late.zero_after_days:
        penalty, value = base + bonus + rubric, 0.0
    if days:
        why.append(Message("batch.late", {"days": days, "penalty": f"{penalty:g}"}))
    return _with(
        given,
        value=rounded(value, course),
        points=base,
        bonus=bonus,
        rubric=rubric,
        late_days=days,
        penalty=penalty,
        why=why,
    )


def _with(given: Mark, **changes: Any) -> Mark:
    changes["why"] = tuple(changes.get("why", given.why))
    return Mark(**{**given.__dict__, **changes})


def verify_people(course: Course, members: list[Member]) -> None:
    """Raise BatchError when a setting names nobody of the class: a slip of the pen costs marks."""
    for name in (*course.people.excused, *course.people.extensions):
        if not any(is_named(each, name) for each in members):
            raise BatchError("batch.course_nobody", name=name)
