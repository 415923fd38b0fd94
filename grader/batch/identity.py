"""Whom a submission is from: what its folder and its AUTEURS.txt say, against the worksheet.

Where two facts about a person disagree, nobody is chosen: the claim is `torn`, and gives no mark.
A likeness of names alone gives way to the folder, which bears Moodle's own number.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from grader.batch.names import is_alike, key_of
from grader.batch.records import Candidate, Enrolled
from grader.batch.roll import Roll, Sender, full_name
from grader.course.message import Message
from grader.intake.authors import Authors, Person


@dataclass(frozen=True)
class SubmittedWork:
    """A candidate, what its AUTEURS.txt says, and a hash of its sources."""

    candidate: Candidate
    authors: Authors | None
    sources: str


@dataclass(frozen=True)
class Claim:
    """That a submission is a person's; `torn`: that it may be, and what keeps it from being.

    `own`: they have handed it in.
    """

    person: Enrolled
    torn: bool = False
    remarks: tuple[Message, ...] = ()
    name: str = ""  # as AUTEURS.txt has it
    number: str = ""
    own: bool = False


def claims(work: SubmittedWork, roll: Roll) -> list[Claim]:
    """Return what a submission says of persons: of each at most one claim that is not torn."""
    sender = roll.sender(work.candidate)
    people = work.authors.people if work.authors else ()
    alone = len(people) == 1 and work.candidate.moodle
    lines = [_Line(person, sender, roll, work.candidate.name, alone) for person in people]
    found = [_checked(claim, sender) for line in lines for claim in line.claims()]
    found = _without_namesakes(found, sender)
    settled = {each.person for each in found if not each.torn}
    found = [each for each in found if not each.torn or each.person not in settled]
    named = {each.person for each in found}
    found += _of_place(work, sender, lines, roll, named)
    problems = work.authors.problems if work.authors else ()
    if found and problems:
        found[0] = replace(found[0], remarks=(*found[0].remarks, *problems))
    return [replace(each, own=each.person in sender.people) for each in found]


def is_known(work: SubmittedWork, roll: Roll, lost: bool) -> bool:
    """Say whether all the authors of a submission are known, once it has been read by `claims`.

    They are not when it cannot be read, when a line of AUTEURS.txt is not understood, or when it
    names somebody whom nothing ties to the worksheet: who seems absent may be one of them. A folder
    of nobody in the worksheet counts only when something is `lost` that was handed in.
    """
    sender = roll.sender(work.candidate)
    if sender.group or not (work.candidate.moodle or sender.people or lost):
        return True
    problems = work.authors.problems if work.authors else ()
    if work.candidate.problem or any(each.key == "authors.not_understood" for each in problems):
        return False
    return work.candidate.name not in roll.strangers


def _checked(claim: Claim, sender: Sender) -> Claim:
    """Return a claim, torn when the folder's number says that it is somebody else's."""
    if claim.torn or claim.person not in sender.torn or claim.person is sender.numbered:
        return claim
    said = (sender.problem,) if sender.problem else ()
    return Claim(claim.person, torn=True, remarks=(*claim.remarks, *said))


def _without_namesakes(found: Sequence[Claim], sender: Sender) -> list[Claim]:
    """Return the claims; that on a namesake of who has handed in is torn, as theirs is.

    The name is both people's, the number one's, and the folder the other's.
    """
    settled = {each.person for each in found if not each.torn}
    senders = [each for each in sender.people if each not in settled]
    checked = []
    for claim in found:
        twins = [each for each in senders if key_of(each.name) == key_of(claim.person.name)]
        if claim.torn or claim.person in sender.people or not twins:
            checked.append(claim)
            continue
        values: dict[str, object] = {"name": claim.name, "number": claim.number}
        said = Message("batch.number_of_namesake", values)
        checked += [Claim(each, torn=True, remarks=(said,)) for each in (claim.person, *twins)]
    return checked


def _of_place(
    work: SubmittedWork, sender: Sender, lines: Sequence[_Line], roll: Roll, named: set[Enrolled]
) -> Iterator[Claim]:
    """Yield what the folder says of those whom AUTEURS.txt does not name."""
    missing = [each for each in sender.people if each not in named]
    yield from (
        Claim(each, torn=True, remarks=(sender.problem,))
        for each in sender.torn
        if sender.problem and each not in named
    )
    if sender.unknown or not lines:
        remarks = (sender.problem,) if sender.problem else ()
        yield from (Claim(each, bool(sender.torn), remarks) for each in missing)
        if not sender.people and not sender.torn:
            label = work.candidate.label
            said = Message("batch.not_enrolled", {"name": label})
            yield Claim(roll.outsider(label), remarks=(said,) if roll.is_listed else ())
        return
    for each in missing:
        values: dict[str, object] = {"name": each.name, "submission": work.candidate.name}
        if not work.candidate.moodle:
            yield Claim(each, torn=True, remarks=(Message("batch.folder_name", values),))
        elif sender.group:
            yield Claim(each, remarks=(Message("batch.member_missing", values),))
        elif len(lines) == 1 and lines[0].is_stranger:
            # The only author is who has handed in, under a name that the worksheet has not.
            yield lines[0].as_sender(each)
        else:
            yield Claim(each, remarks=(Message("batch.sender_missing", values),))


class _Line:
    """A line of AUTEURS.txt, and whom it means."""

    def __init__(
        self, person: Person, sender: Sender, roll: Roll, submission: str, alone: bool
    ) -> None:
        self.name = full_name(person)
        self.number = person.number
        self._sender, self._roll, self._submission = sender, roll, submission
        self._alone = alone  # nobody else is named, in a folder that Moodle has named
        self._numbered = roll.numbered(person.number)
        self._named = roll.named(self.name)
        self.is_stranger = False

    def claims(self) -> list[Claim]:
        """Return the claim on the person who is meant; on several, torn, when that is not sure."""
        if self._numbered:
            found = self._by_number()
        elif self.number:
            found = self._by_name_despite_number()
        else:
            found = self._by_name()
        if self._sender.group:
            return [self._in_group(each) for each in found]
        return found

    def _by_number(self) -> list[Claim]:
        """Return whom the number means: the name must be theirs too, or nobody else's at least."""
        same = [each for each in self._numbered if key_of(each.name) == key_of(self.name)]
        if not same:
            senders = self._sender.people
            alike = [each for each in self._numbered if is_alike(each.name, self.name)]
            same = [each for each in alike if each in senders or not self._named]
        if len(same) == 1:
            return [self._settled(same[0])]
        if self._numbered == [*self._sender.people] and not self._named:
            return [self._settled(self._numbered[0], "batch.name_differs")]
        if self._named:
            others = ", ".join(each.name for each in self._numbered)
            return self._torn([*self._numbered, *self._named], "batch.two_people", other=others)
        others = ", ".join(each.name for each in self._numbered)
        return self._torn(self._numbered, "batch.other_name", other=others)

    def _by_name_despite_number(self) -> list[Claim]:
        """Return whom the name means; the number is a slip of the pen when the folder says who."""
        if sender := self._as_sender():
            key = "batch.number_differs" if sender.number else ""
            return [self._settled(sender, key, known=sender.number)]
        without = [each for each in self._named if not each.number]
        if len(self._named) == len(without) == 1:
            return [self._settled(without[0])]
        if self._named and self._roll.is_listed:
            known = ", ".join(each.number or "-" for each in self._named)
            return self._torn(self._named, "batch.other_number", known=known)
        return self._stranger()

    def _by_name(self) -> list[Claim]:
        if sender := self._as_sender():
            return [self._settled(sender)]
        if len(self._named) == 1:
            return [self._settled(self._named[0])]
        if self._named:
            return self._torn(self._named, "batch.namesakes")
        return self._stranger()

    def _as_sender(self) -> Enrolled | None:
        """Return who has handed in, when that name is theirs; of several nobody."""
        people = self._sender.people
        same = [each for each in people if key_of(each.name) == key_of(self.name)]
        if not same and not self._named:
            same = [each for each in people if is_alike(each.name, self.name)]
        return same[0] if len(same) == 1 else None

    def _stranger(self) -> list[Claim]:
        """Return somebody whom the worksheet has not; somebody of nearly that name may be meant."""
        self.is_stranger = True
        near = [each for each in self._roll.listed if is_alike(each.name, self.name)]
        found = self._torn(near, "batch.nearly")
        if self._alone and self._sender.people and (self._roll.is_anonymous or not self.number):
            return found  # it is who has handed in
        if not self.number or not self._roll.has_numbers:
            self._roll.strangers.add(self._submission)
        person = self._roll.outsider(self.name, self.number)
        said = Message("batch.not_enrolled", {"name": self.name})
        remarks = (said,) if self._roll.is_listed else ()
        return [*found, Claim(person, remarks=remarks, name=self.name, number=self.number)]

    def as_sender(self, person: Enrolled) -> Claim:
        """Return the claim on who has handed in, under another name."""
        return self._settled(person, "" if self._roll.is_anonymous else "batch.name_differs")

    def _settled(self, person: Enrolled, key: str = "", **values: object) -> Claim:
        said = Message(key, {**self._values(), **values}) if key else None
        return Claim(person, remarks=(said,) if said else (), name=self.name, number=self.number)

    def _torn(self, people: Sequence[Enrolled], key: str, **values: object) -> list[Claim]:
        said = Message(key, {**self._values(), **values})
        return [Claim(each, torn=True, remarks=(said,)) for each in dict.fromkeys(people)]

    def _in_group(self, claim: Claim) -> Claim:
        """Return a claim, torn for who is not in the group: it is whom Moodle says."""
        if claim.torn or claim.person in self._sender.people:
            return claim
        said = Message("batch.not_in_group", self._values())
        return Claim(claim.person, torn=True, remarks=(*claim.remarks, said))

    def _values(self) -> dict[str, object]:
        return {"submission": self._submission, "name": self.name, "number": self.number}
