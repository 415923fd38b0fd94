"""Records of the batch: frozen, without any input or output."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any

from grader.course.message import Message, UserError

_WRONG_USE = {
    *("batch.no_submissions", "batch.not_moodle", "batch.not_ours", "batch.seen"),
    *("batch.portable_flag", "batch.portable_no"),
}


class BatchError(UserError):
    """The batch cannot begin, or go on: a sentence of [batch] in messages/."""

    def __init__(self, key: str, **values: object) -> None:
        super().__init__(key, **values)
        self.code = 2 if key in _WRONG_USE else 3


@dataclass(frozen=True)
class Candidate:
    """One submission as it was found: where to read it, and what its place says of its author.

    `number` is Moodle's number of the participant, or of the group; "" elsewhere. `problem` says
    why there is nothing to grade; `remarks` are what to know all the same.
    """

    name: str  # unique in the batch, and safe as the name of a folder
    label: str  # as a person would say it: the student's name, or that of the folder
    path: Path
    number: str = ""
    problem: Message | None = None
    remarks: tuple[Message, ...] = ()
    moodle: bool = False  # whether Moodle has named its folder


@dataclass(frozen=True, eq=False)
class Enrolled:
    """A person of the grading worksheet, or another one of whom submissions speak.

    Two of the same name are two. `row` is their place in the worksheet; -1 when they are not there.
    """

    moodle: str  # Moodle's number of the participant
    name: str
    number: str = ""  # the student's
    group: str = ""  # for which Moodle has one submission
    row: int = -1
    handed: datetime | None = None  # when their work was last changed
    due: datetime | None = None
    extended: datetime | None = None  # their own deadline, as Moodle has granted it
    late: bool = False  # as Moodle says
    draft: bool = False
    online: bool = False  # they have written a text in Moodle


@dataclass(frozen=True)
class Settings:
    """What grading depends on beside the submission; the same for the whole batch."""

    language: str
    isolation: str
    hint: int = 1
    expected: str = ""  # the folder of expected data; "" for the project's own
    gallery: bool = False  # whether pictures are drawn for the class page
    seed: int = -1  # of the inputs that no student has seen; -1 for none
    fresh: str = ""  # their folder, on this machine


@dataclass(frozen=True)
class Task:
    """A submission to grade. It can be sent to another process or machine."""

    name: str
    label: str
    files: Mapping[str, bytes]
    submission: Mapping[str, Any]  # the other fields of the submission's record
    settings: Settings


@dataclass(frozen=True)
class GradedFiles:
    """What grading gave: the files of the student's folder, by name; and the seconds it took.

    `failure` is the grader's or the machine's fault: there are no files then.
    """

    name: str
    files: Mapping[str, bytes] = field(default_factory=dict)
    seconds: float = 0.0
    cpu: float = 0.0
    failure: str = ""
    incomplete: bool = False  # a check could not be made: of no value as a mark


@dataclass(frozen=True, eq=False)
class Member:
    """One person of the class, as one line of grades.csv; two of the same name are two.

    Of who is `unsettled` it is not known what they have handed in: no mark, and `remarks` say why.
    """

    name: str
    number: str = ""  # the student's
    moodle: str = ""  # Moodle's number of the participant
    submission: str = ""  # the name of the candidate; "" when there is none
    remarks: tuple[Message, ...] = ()
    unsettled: bool = False
    team: str = ""
    enrolled: Enrolled | None = None
    handed: datetime | None = None  # when the submission was


@dataclass(frozen=True)
class ManualMark:
    """What manual.csv says of one person or submission, in units of the scale."""

    line: int
    rubric: Mapping[str, float]  # points to add, by column
    comment: str = ""
    override: float | None = None
    reason: str = ""


@dataclass(frozen=True, eq=False)
class Mark:
    """One person's mark; `value` is None when there is none, and `why` says why."""

    member: Member
    value: float | None
    points: float = 0.0
    bonus: float = 0.0
    rubric: float = 0.0
    late_days: int = 0
    penalty: float = 0.0
    comment: str = ""
    why: tuple[Message, ...] = ()
    error: bool = False  # the grader's or the machine's fault
    late: Message | None = None  # what lateness has taken off, for the student


@dataclass(frozen=True)
class Graded:
    """A candidate and what is known of it at the end of a run.

    Of what is `settled`, the checks that the machine fails at count as failed.
    """

    candidate: Candidate
    results: Mapping[str, Any] | None = None  # the content of results.json
    failure: str = ""
    parts: Mapping[str, str] = field(default_factory=dict)  # what the result depends on, hashed
    seconds: float = 0.0
    cpu: float = 0.0
    settled: bool = False
