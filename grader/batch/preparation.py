"""All that is known before the first submission is graded: who is in the class, and what is wrong.

An error in manual.csv, in [people] or in the worksheet stops here, not after half an hour.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from grader.batch import grades_csv, last_run, manual_marks, moodle_worksheet
from grader.batch.lateness import Deadlines
from grader.batch.marks import verify_people
from grader.batch.moodle_worksheet import Worksheet
from grader.batch.records import BatchError, ManualMark, Member
from grader.batch.roster import members
from grader.batch.tasks import TaskReader
from grader.course.message import Message
from grader.course.settings import Course

_OURS = (manual_marks.NAME, grades_csv.GRADES, last_run.CHANGES)


@dataclass(frozen=True)
class Asked:
    """What the command line and the settings ask for."""

    path: Path
    course: Course
    worksheet: Path | None
    names: bool


@dataclass(frozen=True)
class Prepared:
    """A class, before it is graded. `notices` are what to know of it as a whole."""

    asked: Asked
    readers: Sequence[TaskReader]
    worksheet: Worksheet | None
    people: Sequence[Member]
    hands: Mapping[Member, ManualMark]
    deadlines: Deadlines
    notices: Sequence[Message]


def beside(path: Path) -> Path:
    """Return the folder of what stands beside the submissions: manual.csv, course.toml."""
    return path if path.is_dir() else path.parent


def prepare(readers: Sequence[TaskReader], strays: Sequence[str], asked: Asked) -> Prepared:
    """Read all that stands beside the submissions. Raises BatchError, with the cure."""
    worksheet, others = _worksheet(asked)
    enrolled = worksheet.enrolled if worksheet else []
    people = members([each.handed for each in readers], enrolled)
    verify_people(asked.course, people)
    path = beside(asked.path) / manual_marks.NAME
    hands = manual_marks.read(path, people, asked.course.marks.scale)
    deadlines = Deadlines(asked.course, enrolled, people)
    unread = [*strays, *(each.name for each in others)]
    notices = [*_told(worksheet, unread), *deadlines.notices()]
    return Prepared(asked, readers, worksheet, people, hands, deadlines, notices)


def _told(worksheet: Worksheet | None, unread: Sequence[str]) -> Iterator[Message]:
    if unread:
        yield Message("batch.strays", {"names": ", ".join(sorted(unread))})
    if worksheet:
        yield from worksheet.unused()


def _worksheet(asked: Asked) -> tuple[Worksheet | None, list[Path]]:
    """Return the grading worksheet, the one that is named or the only one beside, and other tables.

    Raises BatchError.
    """
    found, others = moodle_worksheet.beside(beside(asked.path), _OURS)
    if asked.worksheet:
        return moodle_worksheet.read(asked.worksheet), others
    if len(found) > 1:
        listed = ", ".join(each.name for each in found)
        raise BatchError("batch.worksheets", names=listed)
    return moodle_worksheet.read(found[0]) if found else None, others
