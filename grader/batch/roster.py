"""The class: one line for each person, with the submission that is theirs, or why none is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import datetime

from grader.batch.contents import some
from grader.batch.identity import Claim, SubmittedWork, claims, is_known
from grader.batch.names import key_of
from grader.batch.records import Enrolled, Member
from grader.batch.roll import Roll
from grader.course.message import Message
from grader.intake import authors
from grader.intake.authors import Authors

ABSENT = "batch.absent"
_Claims = list[tuple[str, Claim]]  # with the submission's name


def read(content: bytes) -> Authors | None:
    """Return what AUTEURS.txt says; None when there is none, or it is as it was handed out."""
    if not content.strip():
        return None
    found = authors.parse(content)
    return found if found.people or len(found.problems) > 1 else None


def members(works: Sequence[SubmittedWork], enrolled: Sequence[Enrolled]) -> list[Member]:
    """Return the members of the class: in the worksheet's order, then others by their names."""
    roll = Roll(enrolled)
    for each in works:
        roll.prepare(each.candidate, each.authors)
    found: dict[Enrolled, _Claims] = {}
    for each in works:
        for claim in claims(each, roll):
            found.setdefault(claim.person, []).append((each.candidate.name, claim))
    dates = _Dates(works, roll, found)
    sources = {each.candidate.name: each.sources for each in works}
    teams = {each.candidate.name: each.authors.group for each in works if each.authors}
    # Something was handed in that lies here under no name, or under another.
    lost = any(each.handed and each not in found for each in roll.listed)
    unsure = [each.candidate.name for each in works if not is_known(each, roll, lost)]
    others = sorted(roll.outsiders, key=lambda each: (key_of(each.name), each.number, each.moodle))
    return [
        _Person(person, found.get(person, []), roll).member(sources, teams, dates, unsure)
        for person in (*roll.listed, *(each for each in others if each in found))
    ]


class _Dates:
    """When each submission was handed in, as far as the worksheet says."""

    def __init__(
        self, works: Sequence[SubmittedWork], roll: Roll, found: Mapping[Enrolled, _Claims]
    ) -> None:
        self._sent = {
            each.candidate.name: _first(roll.sender(each.candidate).people) for each in works
        }
        self._people: dict[str, list[Enrolled]] = {}
        for person, own in found.items():
            for name, claim in own:
                if not claim.torn:
                    self._people.setdefault(name, []).append(person)

    def of(self, person: Enrolled, names: Sequence[str]) -> datetime | None:
        """Return when a person's work was handed in: by who did, else by any of its authors.

        The same work may have been handed in by several: the first date counts.
        """
        sent = [moment for name in names if (moment := self._sent[name])]
        if sent or person.handed:
            return min(sent, default=person.handed)
        return _first([each for name in names for each in self._people.get(name, [])])

    def is_own(self, person: Enrolled, names: Sequence[str]) -> bool:
        """Say whether a person's own date is that of one of these submissions."""
        return any(self._sent[name] in (None, person.handed) for name in names)


def _first(people: Sequence[Enrolled]) -> datetime | None:
    return min((each.handed for each in people if each.handed), default=None)


class _Person:
    """What submissions say of one person."""

    def __init__(self, person: Enrolled, own: _Claims, roll: Roll) -> None:
        self._person, self._own, self._roll = person, own, roll
        self._settled = [(name, claim) for name, claim in own if not claim.torn]

    def member(
        self,
        sources: Mapping[str, str],
        teams: Mapping[str, str],
        dates: _Dates,
        unsure: Sequence[str],
    ) -> Member:
        """Return the line of that person; of several submissions that differ, none is chosen.

        `unsure` are submissions whose authors are not all known.
        """
        # Of a folder of one's own that is not sure, another submission does not take the place.
        rivals = [name for name, claim in self._own if claim.torn and claim.own]
        names = list(dict.fromkeys(name for name, _ in self._settled))
        names += [name for name in dict.fromkeys(rivals) if names and name not in names]
        same = len({sources[name] for name in names}) == 1
        nothing = [] if self._own else [self._nothing(unsure)]
        remarks = [remark for _, claim in self._own for remark in claim.remarks] + nothing
        if len(names) > 1:
            key = "batch.doubled_same" if same else "batch.doubled"
            remarks.append(Message(key, {"places": ", ".join(names)}))
        if names and self._person.handed and not dates.is_own(self._person, names):
            remarks.append(Message("batch.other_date", {"date": said(self._person.handed)}))
        if self._person.draft:
            remarks.append(Message("batch.draft"))
        torn = list(dict.fromkeys(name for name, _ in self._own)) if not names else []
        submission = names[0] if names else torn[0] if len(torn) == 1 else ""
        absent = [each.key for each in nothing] == [ABSENT]
        return Member(
            *(self._name(), self._number(), self._person.moodle, submission),
            remarks=tuple(remarks),
            unsettled=not absent and not (names and same),
            team=teams.get(submission, ""),
            enrolled=self._person,
            handed=dates.of(self._person, names) if names else None,
        )

    def _nothing(self, unsure: Sequence[str]) -> Message:
        """Return why there is no submission of that person."""
        if self._person.online:
            return Message("batch.online")
        if self._person.handed:
            return Message("batch.not_there", {"date": said(self._person.handed)})
        if unsure:
            return Message("batch.perhaps", {"places": some(unsure)})
        return Message(ABSENT)

    def _name(self) -> str:
        """Return the worksheet's name; that of AUTEURS.txt where it is hidden."""
        if self._roll.is_listed and not self._roll.is_anonymous:
            return self._person.name
        written = [claim.name for _, claim in self._settled if claim.name]
        return written[0] if written else self._person.name

    def _number(self) -> str:
        written = [claim.number for _, claim in self._settled if claim.number]
        return self._person.number or (written[0] if written else "")


def said(moment: datetime) -> str:
    """Return a date as it is written for a person and read by spreadsheets."""
    return moment.strftime("%Y-%m-%d %H:%M")
