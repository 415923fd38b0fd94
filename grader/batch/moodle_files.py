"""What goes back to Moodle: the worksheet filled in a copy, and the archive of feedback files.

Written after what Moodle's importer does: see grader/batch/MOODLE.md.
"""

from __future__ import annotations

import html
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from decimal import ROUND_HALF_UP, Decimal
from pathlib import Path

from grader.batch import csv_table
from grader.batch.moodle_dates import as_iso, read_moment
from grader.batch.moodle_worksheet import Worksheet, with_rows
from grader.batch.records import Mark
from grader.course.message import Message
from grader.course.texts import Texts
from grader.files import write_whole, zipped

FEEDBACK = "report.html"
_NO = ("no", "non")


@dataclass(frozen=True)
class Filled:
    """The copy, what was written in it by participant, and what to know of it."""

    content: bytes
    grades: Mapping[str, str]
    comments: Mapping[str, str]
    told: Sequence[Message]


def with_lateness(mark: Mark, texts: Texts) -> Mark:
    """Return a mark whose comment says what lateness has taken off."""
    late = texts.say(mark.late.key, **mark.late.values) if mark.late else ""
    return replace(mark, comment=" ".join(filter(None, (mark.comment, late))))


@dataclass
class _Copy:
    worksheet: Worksheet
    scale: float
    before: Mapping[str, str]  # comments that an earlier run has written
    grades: dict[str, str] = field(default_factory=dict)
    comments: dict[str, str] = field(default_factory=dict)
    told: list[Message] = field(default_factory=list)


def filled(
    worksheet: Worksheet,
    marks: Sequence[Mark],
    scale: float,
    before: Mapping[str, str] | None = None,
) -> Filled:
    """Return the worksheet with the marks, which are out of `scale`.

    `before` are the comments that the last run has written.
    """
    by_number = {each.member.moodle: each for each in marks if each.member.moodle}
    copy = _Copy(worksheet, scale, before or {})
    rows, maxima = [], set()
    for line, row in zip(worksheet.sheet.lines, worksheet.sheet.rows, strict=True):
        mark = by_number.get(worksheet.participant(row))
        cells = [*row, *[""] * (len(worksheet.sheet.header) - len(row))]
        if mark is not None:
            _fill(copy, cells, line, mark)
            maxima.add(worksheet.most(row) or scale)
        rows.append(cells)
    if others := sorted(maxima - {scale}):
        values: dict[str, object] = {
            "scale": float(scale),
            "most": ", ".join(f"{each:g}" for each in others),
        }
        copy.told.insert(0, Message("batch.converted", values))
    content = csv_table.written(with_rows(worksheet, rows))
    return Filled(content, copy.grades, copy.comments, copy.told)


def _fill(copy: _Copy, cells: list[str], line: int, mark: Mark) -> None:
    worksheet, columns = copy.worksheet, copy.worksheet.columns
    number = worksheet.participant(cells)
    comment = html.escape(csv_table.inert(mark.comment), quote=False)
    if columns["feedback"] >= 0 and (comment or _is_ours(copy, cells)):
        cells[columns["feedback"]] = copy.comments[number] = comment
    if mark.value is not None:
        most = worksheet.most(cells) or copy.scale
        text = _points(mark.value * most / copy.scale).replace(".", worksheet.decimal)
        copy.told += _obstacles(worksheet, cells, line, mark, text)
        cells[columns["grade"]] = copy.grades[number] = text
    if number in copy.grades or number in copy.comments:
        _date(worksheet, cells)


def _points(value: float) -> str:
    """Return a grade to the hundredth, a half upwards."""
    return str(Decimal(str(round(value, 9))).quantize(Decimal("0.01"), ROUND_HALF_UP))


def _is_ours(copy: _Copy, cells: Sequence[str]) -> bool:
    """Whether the comment that stands there is the last run's: it goes when there is none now."""
    earlier = copy.worksheet.cell(cells, "feedback")
    return bool(earlier) and earlier == copy.before.get(copy.worksheet.participant(cells))


def _date(worksheet: Worksheet, cells: list[str]) -> None:
    """Write the date of the grade so that every site reads it; that of the submission without one.

    Moodle passes over a grade that is newer than this date.
    """
    at = worksheet.columns["graded"]
    moments = (read_moment(worksheet.cell(cells, name)) for name in ("graded", "handed"))
    if at >= 0 and (moment := next((each for each in moments if each), None)):
        cells[at] = as_iso(moment)


def _obstacles(
    worksheet: Worksheet, cells: Sequence[str], line: int, mark: Mark, text: str
) -> list[Message]:
    """Return what may keep a grade from arriving."""
    values: dict[str, object] = {"line": line, "name": mark.member.name}
    if csv_table.plain(worksheet.cell(cells, "changeable")) in _NO:
        return [Message("batch.row_locked", values)]
    before = worksheet.cell(cells, "grade").strip("- ")
    if before and csv_table.number(before) != csv_table.number(text):
        return [Message("batch.row_changed", {**values, "before": before, "mark": text})]
    return []


def write_feedback(path: Path, pages: Mapping[str, bytes]) -> None:
    """Write the archive of feedback files: for each name of a Moodle folder, a student's page."""
    write_whole(path, zipped({f"{name}/{FEEDBACK}": each for name, each in pages.items()}))


def folder_name(label: str, number: str) -> str:
    """Return the name of a person's or a group's folder, as Moodle's own archive has it."""
    clean = re.sub(r'["*:<>?|\\/]', "", label.replace("_", " "))
    return f"{clean}_{number}_assignsubmission_file_"
