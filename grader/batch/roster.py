"""Who made what: one line for each person; what is doubled is said, never settled in silence."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from grader.batch.records import Candidate, Member
from grader.course.message import Message
from grader.intake import authors
from grader.intake.authors import Authors, Person


@dataclass(frozen=True)
class SubmittedWork:
    """A candidate, what its AUTEURS.txt says, and a hash of its sources."""

    candidate: Candidate
    authors: Authors | None
    sources: str


@dataclass(frozen=True)
class Enrolled:
    """A person of the grading worksheet."""

    moodle: str
    name: str
    number: str = ""


def key_of(name: str) -> str:
    """Return a name without case, accents and order: what two spellings of it share."""
    plain = unicodedata.normalize("NFKD", name.casefold())
    letters = "".join(each for each in plain if not unicodedata.combining(each))
    return " ".join(sorted(re.findall(r"\w+", letters)))


def read(content: bytes) -> Authors | None:
    """Return what AUTEURS.txt says; None when there is none, or it is as it was handed out."""
    if not content.strip():
        return None
    found = authors.parse(content)
    return found if found.people or len(found.problems) > 1 else None


def members(handed: Sequence[SubmittedWork], enrolled: Sequence[Enrolled]) -> list[Member]:
    """Return the members of the class: those of the submissions, then who has handed in nothing."""
    roll = _Roll(enrolled)
    lines = [line for each in handed for line in _of_submission(each, roll)]
    sources = {each.candidate.name: each.sources for each in handed}
    merged = _merged(lines, sources)
    present = {each.moodle for each in merged if each.moodle}
    absent = [
        Member(each.name, each.number, each.moodle, remarks=(Message("batch.absent"),))
        for each in enrolled
        if each.moodle not in present
    ]
    return sorted([*merged, *absent], key=lambda each: (key_of(each.name), each.number, each.name))


class _Roll:
    """The persons of the worksheet, by what a submission may say of them."""

    def __init__(self, enrolled: Iterable[Enrolled]) -> None:
        self._moodle: dict[str, Enrolled] = {}
        self._numbers: dict[str, Enrolled] = {}
        self._names: dict[str, list[Enrolled]] = {}
        for each in enrolled:
            self._moodle[each.moodle] = each
            if each.number:
                self._numbers[_digits(each.number)] = each
            self._names.setdefault(key_of(each.name), []).append(each)

    def __bool__(self) -> bool:
        return bool(self._moodle)

    def by_moodle(self, moodle: str) -> Enrolled | None:
        return self._moodle.get(moodle)

    def by_person(self, name: str, number: str) -> Enrolled | None:
        """Return the person of that number, or of that name when only one has it."""
        if number and (found := self._numbers.get(_digits(number))):
            return found
        same = self._names.get(key_of(name), [])
        return same[0] if len(same) == 1 else None


def _digits(number: str) -> str:
    return re.sub(r"\D", "", number) or number


def _of_submission(handed: SubmittedWork, roll: _Roll) -> list[Member]:
    candidate, said = handed.candidate, handed.authors
    sender = _sender(candidate, roll)
    if said is None or not said.people:
        problems = said.problems if said else ()
        return [replace(sender, remarks=problems)]
    lines = [_of_person(person, said, candidate, roll) for person in said.people]
    lines = [replace(lines[0], remarks=said.problems), *lines[1:]]
    if not candidate.number:
        return lines
    for k, line in enumerate(lines):
        same_name = key_of(line.name) == key_of(sender.name)
        if line.moodle == sender.moodle or (not line.moodle and same_name):
            lines[k] = replace(line, moodle=sender.moodle)
            return lines
    if re.fullmatch(r"\D+\d+", sender.name) and len(lines) == 1:  # anonymous marking
        return [replace(lines[0], moodle=sender.moodle)]
    remark = Message("batch.sender_missing", {"name": sender.name})
    return [*lines, replace(sender, remarks=(remark,))]


def _sender(candidate: Candidate, roll: _Roll) -> Member:
    known = roll.by_moodle(candidate.number)
    if known is None and not candidate.number:
        known = roll.by_person(candidate.label, "")
    name, number = (known.name, known.number) if known else (candidate.label, "")
    moodle = known.moodle if known else candidate.number
    return Member(name, number, moodle, candidate.name)


def _of_person(person: Person, said: Authors, candidate: Candidate, roll: _Roll) -> Member:
    name = f"{person.first_name} {person.surname}".strip()
    known = roll.by_person(name, person.number)
    remarks: tuple[Message, ...] = ()
    if roll and known is None:
        remarks = (Message("batch.not_enrolled", {"name": name}),)
    moodle = known.moodle if known else ""
    number = person.number or (known.number if known else "")
    return Member(name, number, moodle, candidate.name, remarks, team=said.group)


def _merged(lines: Sequence[Member], sources: Mapping[str, str]) -> list[Member]:
    """Return one line for each person; of several submissions that differ, none is chosen."""
    groups: list[list[Member]] = []
    places: dict[str, int] = {}
    for line in lines:
        keys = [f"moodle {line.moodle}"] if line.moodle else []
        keys += [f"number {_digits(line.number)}"] if line.number else []
        keys += [] if keys else [f"name {key_of(line.name)}"]
        at = next((places[key] for key in keys if key in places), len(groups))
        if at == len(groups):
            groups.append([])
        groups[at].append(line)
        places |= {key: at for key in keys if key not in places}
    return [_one(each, sources) for each in groups]


def _one(lines: Sequence[Member], sources: Mapping[str, str]) -> Member:
    first = lines[0]
    names = list(dict.fromkeys(each.submission for each in lines))
    remarks = tuple(remark for each in lines for remark in each.remarks)
    moodle = next((each.moodle for each in lines if each.moodle), "")
    number = next((each.number for each in lines if each.number), "")
    merged = replace(first, moodle=moodle, number=number, remarks=remarks)
    if len(names) == 1:
        return merged
    same = len({sources[name] for name in names}) == 1
    key = "batch.doubled_same" if same else "batch.doubled"
    told = (*remarks, Message(key, {"places": ", ".join(names)}))
    return replace(merged, remarks=told, doubled=not same)
