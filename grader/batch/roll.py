"""The persons of the class: those of the worksheet, and others of whom submissions speak."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from grader.batch.names import digits_of, is_alike, is_folder_of, key_of
from grader.batch.records import Candidate, Enrolled
from grader.course.message import Message
from grader.intake.authors import Authors, Person

_NUMBER = re.compile(r"\d{4,}")
_HIDDEN_NAME = re.compile(r"\D*\d+")  # "Participant 12", when marking is anonymous


def full_name(person: Person) -> str:
    """Return a name as it is said: the first name first."""
    return f"{person.first_name} {person.surname}".strip()


@dataclass(frozen=True)
class Sender:
    """Who has handed in, as far as the folder says; `torn` are those whom it may mean as well.

    `numbered` has the folder's number. `group`: Moodle has one submission for all of them.
    `unknown`: the worksheet has not that number.
    """

    people: tuple[Enrolled, ...] = ()
    torn: tuple[Enrolled, ...] = ()
    numbered: Enrolled | None = None
    problem: Message | None = None
    group: bool = False
    unknown: bool = False


class Roll:
    """Finds persons by number, by name, by folder."""

    def __init__(self, enrolled: Iterable[Enrolled]) -> None:
        self.listed = list(enrolled)
        self.outsiders: list[Enrolled] = []
        self.strangers: set[str] = set()  # submissions that name somebody who may be anybody
        self._numbers: dict[str, list[Enrolled]] = {}
        self._names: dict[str, list[Enrolled]] = {}
        self._moodle = {each.moodle: each for each in self.listed if each.moodle}
        self._senders: dict[str, Sender] = {}
        for each in self.listed:
            self._file(each)

    def _file(self, person: Enrolled) -> None:
        self._names.setdefault(key_of(person.name), []).append(person)
        if person.number:
            self._numbers.setdefault(digits_of(person.number), []).append(person)

    def prepare(self, candidate: Candidate, authors: Authors | None) -> None:
        """Note a sender before any AUTEURS.txt is read, for want of a worksheet."""
        if self.is_listed or not candidate.moodle:
            return
        people = authors.people if authors else ()
        own = [each for each in people if is_alike(full_name(each), candidate.label)]
        self.outsider(candidate.label, own[0].number if len(own) == 1 else "", candidate.number)

    @property
    def is_listed(self) -> bool:
        """Whether there is a worksheet."""
        return bool(self.listed)

    @property
    def has_numbers(self) -> bool:
        """Whether the worksheet has the students' numbers."""
        return any(each.number for each in self.listed)

    @property
    def is_anonymous(self) -> bool:
        """Whether the worksheet hides the names."""
        return self.is_listed and all(_HIDDEN_NAME.fullmatch(each.name) for each in self.listed)

    def numbered(self, number: str) -> list[Enrolled]:
        """Return who has that student's number."""
        return self._numbers.get(digits_of(number), []) if number else []

    def named(self, name: str) -> list[Enrolled]:
        """Return who has that name, whatever the case, the accents and the order."""
        return self._names.get(key_of(name), [])

    def outsider(self, name: str, number: str = "", moodle: str = "") -> Enrolled:
        """Return a person whom the worksheet has not; the same one for the same facts."""
        for each in self.outsiders:
            alike = is_alike(each.name, name)
            if moodle or each.moodle:
                same = moodle == each.moodle
            elif number and each.number:
                same = alike and digits_of(number) == digits_of(each.number)
            else:
                same = key_of(name) == key_of(each.name)
            if same:
                return each
        person = Enrolled(moodle, name, number)
        self.outsiders.append(person)
        self._file(person)
        return person

    def sender(self, candidate: Candidate) -> Sender:
        """Return who has handed in a submission, as far as its folder says."""
        if candidate.name not in self._senders:
            find = self._of_moodle if candidate.moodle else self._of_folder
            self._senders[candidate.name] = find(candidate)
        return self._senders[candidate.name]

    def _of_moodle(self, candidate: Candidate) -> Sender:
        label, number = candidate.label, candidate.number
        if not self.is_listed:
            return Sender((self.outsider(label, moodle=number),))
        row = self._moodle.get(number)
        if row and self.is_anonymous:
            return Sender((row,))
        bearers = [each for each in self.listed if is_folder_of(label, each.name)]
        group = self._group(label)
        if group and (row is None or row not in bearers or row in group):
            return Sender(tuple(group), group=True)
        if row and (row in bearers or is_folder_of(label, f"{row.group} {row.name}")):
            return Sender((row,))
        return self._unsure(candidate, row, bearers)

    def _unsure(
        self, candidate: Candidate, row: Enrolled | None, bearers: Sequence[Enrolled]
    ) -> Sender:
        """Return the sender of a folder whose name and number are not one person's."""
        values: dict[str, object] = {
            "submission": candidate.name,
            "number": candidate.number,
            "name": candidate.label,
        }
        if row:
            problem = Message("batch.folder_torn", {**values, "other": row.name})
            torn = tuple(dict.fromkeys([row, *bearers]))
            return Sender(torn=torn, numbered=row, problem=problem)
        person = self.outsider(candidate.label, moodle=candidate.number)
        key = "batch.folder_other_number" if bearers else "batch.not_enrolled"
        problem = Message(key, values)
        return Sender((person,), tuple(bearers), problem=problem, unknown=True)

    def _of_folder(self, candidate: Candidate) -> Sender:
        """Return whom a folder of any name is from: its name may be a person's, or their number."""
        label = candidate.label
        found = [each for word in _NUMBER.findall(label) for each in self.numbered(word)]
        found = list(dict.fromkeys([*found, *self.named(_NUMBER.sub(" ", label))]))
        group = self._group(label) if not found else []
        if group or len(found) == 1:
            return Sender(tuple(group or found), group=bool(group))
        values: dict[str, object] = {"submission": candidate.name, "name": label}
        if found:
            return Sender(torn=tuple(found), problem=Message("batch.folder_namesakes", values))
        return Sender()

    def _group(self, label: str) -> list[Enrolled]:
        return [each for each in self.listed if each.group and is_folder_of(label, each.group)]
