"""How late each person is: the course's deadline, their own, and what Moodle says of both.

An extension of [people] goes first. Else what Moodle has granted a person counts, when it is later
than the course's deadline. Where they differ, it is said.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta

from grader.batch.contents import some
from grader.batch.moodle_dates import as_iso
from grader.batch.names import is_named
from grader.batch.records import Enrolled, Member
from grader.course.message import Message
from grader.course.settings import Course

_SAME = timedelta(minutes=1)  # the worksheet has no seconds


@dataclass(frozen=True)
class Lateness:
    """Days begun after a person's deadline, and what is to be known of it.

    `unknown`: when the work was handed in may be on the line of somebody who has no mark.
    """

    days: int = 0
    remarks: tuple[Message, ...] = ()
    unknown: bool = False


class Deadlines:
    """The deadlines of a class."""

    def __init__(
        self, course: Course, enrolled: Sequence[Enrolled], people: Sequence[Member] = ()
    ) -> None:
        self._course, self._enrolled = course, enrolled
        self._lost = [
            each.name
            for each in people
            if each.unsettled and each.enrolled and each.enrolled.handed
        ]
        self._common = _common([each.due for each in enrolled if each.due], course.deadline)
        self._is_dated = any(each.handed for each in enrolled)

    def notices(self) -> list[Message]:
        """Return what is to be known of the whole class."""
        deadline, found = self._course.deadline, []
        if deadline and not self._is_dated:
            found.append(Message("batch.no_dates", {"deadline": as_iso(deadline)}))
        if deadline and self._common and abs(self._common - deadline) >= _SAME:
            values: dict[str, object] = {"moodle": as_iso(self._common), "own": as_iso(deadline)}
            found.append(Message("batch.other_deadline", values))
        late = [each for each in self._enrolled if each.late]
        granted = [each for each in self._enrolled if each.extended]
        if not deadline and (self._common or late or granted):
            values = {"late": len(late), "granted": len(granted)}
            found.append(Message("batch.no_deadline", values))
        return found

    def of(self, member: Member) -> Lateness:
        """Return how late a person is."""
        deadline, remarks = self._own(member)
        if deadline is None:
            return Lateness()
        if member.handed is None:
            if self._lost:
                values: dict[str, object] = {"names": some(self._lost)}
                return Lateness(0, (*remarks, Message("batch.lost_date", values)), unknown=True)
            remarks += [Message("batch.no_date")] if self._is_dated else []
            return Lateness(0, tuple(remarks))
        grace = timedelta(minutes=self._course.late.grace_minutes)
        days = math.ceil((member.handed - deadline - grace) / timedelta(days=1))
        if days <= 0 and member.enrolled and member.enrolled.late:
            remarks.append(Message("batch.moodle_late", {"deadline": as_iso(deadline)}))
        return Lateness(max(0, days), tuple(remarks))

    def _own(self, member: Member) -> tuple[datetime | None, list[Message]]:
        """Return a person's deadline, and what is to be known of it."""
        people = self._course.people.extensions
        mine = next((people[name] for name in people if is_named(member, name)), None)
        granted = self._granted(member.enrolled)
        deadline = mine or self._course.deadline
        if deadline is None or granted is None or abs(granted - deadline) < _SAME:
            return deadline, []
        values: dict[str, object] = {"moodle": as_iso(granted), "own": as_iso(deadline)}
        if mine or granted < deadline:
            return deadline, [Message("batch.other_extension", values)]
        return granted, [Message("batch.granted", values)]

    def _granted(self, person: Enrolled | None) -> datetime | None:
        """Return the deadline that Moodle has for one person and not for the class."""
        if person is None:
            return None
        own = person.due if person.due != self._common else None
        return max((each for each in (person.extended, own) if each), default=None)


def _common(moments: Sequence[datetime], deadline: datetime | None) -> datetime | None:
    """Return the date that most persons have; the course's own when some have it."""
    if deadline and any(abs(each - deadline) < _SAME for each in moments):
        return next(each for each in moments if abs(each - deadline) < _SAME)
    counts = Counter(moments)
    return max(sorted(counts), key=lambda each: counts[each], default=None)
