"""What a batch gives back, from what is known of each submission: reads JSON only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from grader.batch import class_page, grades_csv, manual_marks, moodle_worksheet
from grader.batch.marks import mark, verify_people
from grader.batch.moodle_worksheet import Worksheet
from grader.batch.records import BatchError, Graded, Mark, Member
from grader.batch.results_folder import STUDENTS, ResultsFolder
from grader.batch.roster import members
from grader.batch.tasks import TaskReader
from grader.course.message import Message
from grader.course.settings import Course
from grader.course.texts import Texts
from grader.files import write_whole
from grader.report.results import write

MOST_LINES = 30  # of one kind, in the terminal


@dataclass(frozen=True)
class Asked:
    """What the command line and the settings ask for."""

    path: Path
    course: Course
    worksheet: Path | None
    names: bool


@dataclass(frozen=True)
class ClassSummary:
    """What to tell at the terminal."""

    lines: list[str]
    failed: bool


def beside(path: Path) -> Path:
    """Return the folder of what stands beside the submissions: manual.csv, course.toml."""
    return path if path.is_dir() else path.parent


def write_all(
    results: ResultsFolder,
    readings: Sequence[TaskReader],
    graded: Mapping[str, Graded],
    asked: Asked,
    texts: Texts,
) -> ClassSummary:
    """Write everything; return what to tell. Raises BatchError."""
    worksheet = _worksheet(asked)
    people = members([each.handed for each in readings], worksheet.enrolled if worksheet else ())
    verify_people(asked.course, people)
    hands = manual_marks.read(
        beside(asked.path) / manual_marks.NAME, people, asked.course.marks.scale
    )
    handed = worksheet.handed if worksheet else {}
    senders = {each.name: each.number for each in (reading.candidate for reading in readings)}
    marks = []
    for person in people:
        # Who has handed in nothing alone was handed in with the one who did.
        moment = handed.get(person.moodle) or handed.get(senders.get(person.submission, ""))
        own = graded.get(person.submission)
        marks.append(mark(person, own, hands.get(person), moment, asked.course))
    before = grades_csv.read_kept(results.out)
    now = grades_csv.kept(marks, graded, repr(asked.course))
    changed = grades_csv.changes(before, now, texts)
    with results.writing(results.out):
        write_whole(results.out / grades_csv.GRADES, grades_csv.grades(marks, graded, texts))
        if changed:
            write_whole(results.out / grades_csv.CHANGES, grades_csv.changes_table(changed, texts))
        told = _moodle(results, worksheet, marks, graded) if worksheet else []
        page = class_page.render(
            marks, graded, asked.course, asked.names, texts, results.out / STUDENTS
        )
        write_whole(results.out / class_page.NAME, page)
        results.forget_others(set(graded))
        write(results.out / grades_csv.MARKS, now)  # last: the next run compares with a whole one
    failed = any(each.error for each in marks)
    return ClassSummary([*_told(results, marks, changed, told, texts)], failed)


def _worksheet(asked: Asked) -> Worksheet | None:
    """Return the grading worksheet: the one that is named, or the only one beside."""
    if asked.worksheet:
        return moodle_worksheet.read(asked.worksheet)
    found = [
        each for each in sorted(beside(asked.path).glob("*.csv")) if each.name != manual_marks.NAME
    ]
    found = [each for each in found if moodle_worksheet.is_worksheet(each)]
    if len(found) > 1:
        listed = ", ".join(each.name for each in found)
        raise BatchError("batch.worksheets", names=listed)
    return moodle_worksheet.read(found[0]) if found else None


def _moodle(
    results: ResultsFolder,
    worksheet: Worksheet,
    marks: Sequence[Mark],
    graded: Mapping[str, Graded],
) -> list[Message]:
    """Write the worksheet and the feedback files; return what Moodle will pass over."""
    content, told = moodle_worksheet.filled(worksheet, marks)
    folder = results.out / "moodle"
    write_whole(folder / worksheet.path.name, content)
    pages = {}
    for each in marks:
        known = graded.get(each.member.submission)
        if each.member.moodle and known and known.results and not each.member.doubled:
            name = moodle_worksheet.folder_name(each.member.name, each.member.moodle)
            pages[name] = results.folder(each.member.submission)
    moodle_worksheet.write_feedback(folder / "feedback.zip", pages)
    known_numbers = {each.moodle for each in worksheet.enrolled}
    lost = [each.member for each in marks if each.member.moodle not in known_numbers]
    return [*told, *(_not_listed(each) for each in lost)]


def _not_listed(member: Member) -> Message:
    return Message("batch.not_listed", {"name": member.name})


def _told(
    results: ResultsFolder,
    marks: Sequence[Mark],
    changed: Sequence[Sequence[str]],
    told: Sequence[Message],
    texts: Texts,
) -> list[str]:
    """Return the lines of the terminal: the errors, the remarks, the changes, then the files."""
    failures = [each for each in marks if each.error]
    remarks = [each for each in marks if each.why and not each.error]
    lines = _some(
        [f"{each.member.name} : {' '.join(grades_csv.sentence(each, texts))}" for each in remarks],
        texts.say("batch.remarks"),
        texts,
    )
    lines += _some(
        [f"{name} : {before} -> {now} ({why})" for name, before, now, why in changed],
        texts.say("batch.changes"),
        texts,
    )
    lines += _some(
        [texts.say(each.key, **each.values) for each in told], texts.say("batch.moodle"), texts
    )
    lines += _some(
        [f"{each.member.name} : {' '.join(grades_csv.sentence(each, texts))}" for each in failures],
        texts.say("batch.errors"),
        texts,
    )
    count = sum(each.value is not None for each in marks)
    path = results.out / class_page.NAME
    lines.append(texts.say("batch.done", marks=count, people=len(marks), path=path))
    return lines


def _some(lines: Sequence[str], title: str, texts: Texts) -> list[str]:
    if not lines:
        return []
    found = [title, *(f"  {_printable(each)}" for each in lines[:MOST_LINES])]
    if len(lines) > MOST_LINES:
        found.append(f"  {texts.say('batch.more', count=len(lines) - MOST_LINES)}")
    return found


def _printable(line: str) -> str:
    """Return a line that a terminal shows and does not obey."""
    return "".join(each if each.isprintable() else "?" for each in " ".join(line.split()))
