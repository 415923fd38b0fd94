"""What a batch gives back, from what is known of each submission: reads JSON only."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from grader.batch import class_page, grades_csv, last_run, marks_xlsx, moodle_files
from grader.batch.marks import mark
from grader.batch.moodle_worksheet import Worksheet
from grader.batch.preparation import Prepared
from grader.batch.records import Graded, Mark
from grader.batch.results_folder import STUDENTS, ResultsFolder
from grader.batch.student_pages import Pages
from grader.course.message import Message
from grader.course.texts import Texts
from grader.files import write_whole
from grader.report.results import write

MOST_LINES = 30  # of one kind, in the terminal
# Sentences that grades.csv and the class page have, and that would hide the others here.
QUIET = ("batch.unread", "batch.given")


@dataclass(frozen=True)
class ClassSummary:
    """What to tell at the terminal."""

    lines: list[str]
    failed: bool


def write_all(
    results: ResultsFolder, prepared: Prepared, graded: Mapping[str, Graded], texts: Texts
) -> ClassSummary:
    """Write everything; return what to tell. Raises BatchError."""
    course = prepared.asked.course
    marks = [
        mark(
            *(person, graded.get(person.submission), prepared.hands.get(person)),
            *(prepared.deadlines.of(person), course),
        )
        for person in prepared.people
    ]
    before = last_run.read(results.out)
    now = {"people": last_run.kept(marks, graded, prepared.hands, course)}
    changed = last_run.changes(before["people"], now["people"], texts)
    hidden = results.pseudonyms(each.member.submission for each in marks if each.member.submission)
    with results.writing(results.out):
        pages = Pages(results, marks, graded, before["pages"], texts)
        pages.write()
        write_whole(
            results.out / grades_csv.GRADES, grades_csv.grades(marks, graded, hidden, texts)
        )
        _write_sheet(results, marks, graded, hidden, texts)
        if changed:
            write_whole(results.out / last_run.CHANGES, last_run.changes_table(changed, texts))
        told, written = _moodle(results, prepared, marks, pages, before, texts)
        shown = None if prepared.asked.names else hidden
        page = class_page.render(marks, graded, course, shown, texts, results.out / STUDENTS)
        write_whole(results.out / class_page.NAME, page)
        results.forget_others(set(graded))
        # Last: the next run compares with a whole one.
        write(results.out / last_run.MARKS, {**now, **written, "pages": pages.made})
    failed = any(each.error for each in marks)
    return ClassSummary([*_told(results, marks, graded, changed, told, texts)], failed)


def _write_sheet(
    results: ResultsFolder,
    marks: Sequence[Mark],
    graded: Mapping[str, Graded],
    hidden: Mapping[str, str],
    texts: Texts,
) -> None:
    """Write marks.xlsx, or remove an older one, which would say other marks."""
    path = results.out / marks_xlsx.NAME
    if marks_xlsx.is_possible():
        write_whole(path, marks_xlsx.marks_sheet(marks, graded, hidden, texts))
    else:
        path.unlink(missing_ok=True)


def _moodle(
    results: ResultsFolder,
    prepared: Prepared,
    marks: Sequence[Mark],
    pages: Pages,
    before: Mapping[str, Any],
    texts: Texts,
) -> tuple[list[Message], dict[str, Any]]:
    """Write the worksheet and the feedback files; return what to know, and what was written."""
    worksheet = prepared.worksheet
    if worksheet is None:
        return [], {"grades": before["grades"], "comments": before["comments"]}
    scale = prepared.asked.course.marks.scale
    shown = [moodle_files.with_lateness(each, texts) for each in marks]
    filled = moodle_files.filled(worksheet, shown, scale, before["comments"])
    folder = results.out / "moodle"
    write_whole(folder / worksheet.path.name, filled.content)
    moodle_files.write_feedback(folder / "feedback.zip", pages.feedback())
    told = [*_older(worksheet, before["grades"], filled.grades), *filled.told, *_lost(marks)]
    separator = Message(_SEPARATORS[worksheet.sheet.delimiter])
    # With its folder: the one beside the submissions has the same name.
    names: dict[str, object] = {"worksheet": folder / worksheet.path.name, "separator": separator}
    told.append(Message("batch.upload", names))
    return told, {"grades": filled.grades, "comments": filled.comments}


_SEPARATORS = {",": "batch.comma", ";": "batch.semicolon", "\t": "batch.tab"}


def _older(
    worksheet: Worksheet, before: Mapping[str, str], now: Mapping[str, str]
) -> Iterator[Message]:
    """Say when the worksheet knows nothing of grades that the last run has given, and that change.

    Moodle passes over a grade that it was given after the worksheet was downloaded.
    """
    rows = {worksheet.participant(row): row for row in worksheet.sheet.rows}
    behind = [
        number
        for number, text in now.items()
        if before.get(number, text) != text
        and worksheet.cell(rows[number], "grade").strip("- ") == ""
    ]
    if behind:
        yield Message("batch.older_worksheet", {"count": len(behind)})


def _lost(marks: Sequence[Mark]) -> Iterator[Message]:
    """Yield who has a mark and no row in the worksheet."""
    for each in marks:
        person = each.member.enrolled
        if each.value is not None and (person is None or person.row < 0):
            yield Message("batch.not_listed", {"name": each.member.name})


def _told(
    results: ResultsFolder,
    marks: Sequence[Mark],
    graded: Mapping[str, Graded],
    changed: Sequence[Sequence[str]],
    told: Sequence[Message],
    texts: Texts,
) -> list[str]:
    """Return the lines of the terminal: the errors, the remarks, the changes, then the files."""
    names = class_page.shown_names(marks)
    lines: list[str] = []

    def about(kind: str, those: Sequence[Mark]) -> None:
        told = []
        for each in those:
            # Of who has no mark, all is to be known.
            leave = () if each.value is None else QUIET
            if sentences := grades_csv.sentence(each, texts, leave):
                told.append(f"{names[each]} : {' '.join(sentences)}")
        lines.extend(_some(told, kind, texts))

    about("batch.remarks", [each for each in marks if not each.error])
    lines += _some([*_of_nobody(marks, graded, texts)], "batch.of_nobody", texts)
    quiet = {each.member.submission for each in marks for why in each.why if why.key in QUIET}
    if quiet:
        lines.append(texts.say("batch.quiet", count=len(quiet)))
    rows = [f"{name} : {old or '-'} -> {new or '-'} ({why})" for name, old, new, why in changed]
    lines += _some(rows, "batch.changes", texts)
    lines += _some([texts.say(each.key, **each.values) for each in told], "batch.moodle", texts)
    about("batch.errors", [each for each in marks if each.error])
    count = sum(each.value is not None for each in marks)
    path = results.out / class_page.NAME
    lines.append(texts.say("batch.done", marks=count, people=len(marks), path=path))
    return lines


def _of_nobody(marks: Sequence[Mark], graded: Mapping[str, Graded], texts: Texts) -> Iterator[str]:
    """Yield what is to be known of submissions that are on nobody's line, since several differ."""
    shown = {each.member.submission for each in marks}
    for name, known in graded.items():
        candidate = known.candidate
        told = [*candidate.remarks, *([candidate.problem] if candidate.problem else [])]
        if name not in shown and told:
            yield f"{name} : {' '.join(texts.say(each.key, **each.values) for each in told)}"


def _some(lines: Sequence[str], title: str, texts: Texts) -> list[str]:
    if not lines:
        return []
    found = [texts.say(title), *(f"  {_printable(each)}" for each in lines[:MOST_LINES])]
    if len(lines) > MOST_LINES:
        found.append(f"  {texts.say('batch.more', count=len(lines) - MOST_LINES)}")
    return found


def _printable(line: str) -> str:
    """Return a line that a terminal shows and does not obey."""
    return "".join(each if each.isprintable() else "?" for each in " ".join(line.split()))
