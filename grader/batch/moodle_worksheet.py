"""Moodle's offline grading worksheet, filled in place, and its archive of feedback files.

Written after what Moodle's importer does: it finds the columns of the identifier, the grade and the
grade's date by their headers in the site's language, and passes over a row whose grade was changed
since the download, is locked, is below zero or above the maximum. Feedback files go to whom the
name of their folder says, `Name_12345_assignsubmission_file_`.
"""

from __future__ import annotations

import html
import io
import re
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path

from grader.batch import csv_table
from grader.batch.csv_table import Sheet
from grader.batch.records import BatchError, Mark
from grader.batch.roster import Enrolled
from grader.course.message import Message
from grader.files import write_whole

_COLUMNS = {
    "id": ("identifier", "identifiant"),
    "name": ("full name", "nom complet"),
    "number": ("id number", "numéro d'identification", "numéro d’identification"),
    "grade": ("grade", "note"),
    "most": ("maximum grade", "note maximale"),
    "changeable": ("grade can be changed", "la note peut être modifiée"),
    "handed": (
        "last modified (submission)",
        "dernière modification (travail remis)",
        "dernière modification (remise)",
    ),
    "graded": ("last modified (grade)", "dernière modification (note)"),
    "feedback": ("feedback comments", "feedback par commentaires", "commentaires de feedback"),
}
_NO = ("no", "non")
_MONTHS = (
    ("january", "janvier"),
    ("february", "février"),
    ("march", "mars"),
    ("april", "avril"),
    ("may", "mai"),
    ("june", "juin"),
    ("july", "juillet"),
    ("august", "août"),
    ("september", "septembre"),
    ("october", "octobre"),
    ("november", "novembre"),
    ("december", "décembre"),
)
_DAY_FIRST = re.compile(
    r"(?P<day>\d{1,2})(?:er)?\s+(?P<month>[^\W\d]+)\s+(?P<year>\d{4})[^\d]+"
    r"(?P<hour>\d{1,2})[:h](?P<minute>\d{2})(?:\s*(?P<half>[AaPp][Mm]))?"
)
_MONTH_FIRST = re.compile(
    r"(?P<month>[^\W\d]+)\s+(?P<day>\d{1,2}),?\s+(?P<year>\d{4})[^\d]+"
    r"(?P<hour>\d{1,2}):(?P<minute>\d{2})(?:\s*(?P<half>[AaPp][Mm]))?"
)
_FEEDBACK = "report.html"


@dataclass(frozen=True)
class Worksheet:
    """A grading worksheet, and where its columns are (-1: it has not got that one)."""

    path: Path
    sheet: Sheet
    columns: Mapping[str, int]

    def cell(self, row: Sequence[str], name: str) -> str:
        """Return a row's cell; "" when it has none."""
        at = self.columns[name]
        return row[at].strip() if 0 <= at < len(row) else ""

    def participant(self, row: Sequence[str]) -> str:
        """Return Moodle's number of a row: the digits that end its identifier."""
        found = re.search(r"(\d+)\s*$", self.cell(row, "id"))
        return found[1] if found else ""

    @property
    def enrolled(self) -> list[Enrolled]:
        """The persons of the worksheet; without names when marking is anonymous."""
        return [
            Enrolled(
                self.participant(row),
                self.cell(row, "name") or self.cell(row, "id"),
                self.cell(row, "number"),
            )
            for row in self.sheet.rows
            if self.participant(row)
        ]

    @property
    def handed(self) -> dict[str, datetime]:
        """When each person's work was last changed, by Moodle's number. Raises BatchError."""
        found = {}
        for line, row in zip(self.sheet.lines, self.sheet.rows, strict=True):
            text = self.cell(row, "handed")
            if text in ("", "-"):
                continue
            moment = read_moment(text)
            if moment is None:
                raise BatchError("batch.worksheet_date", path=self.path, line=line, text=text)
            found[self.participant(row)] = moment
        return found

    @property
    def decimal(self) -> str:
        """The decimal sign: that of the numbers that stand there; else the language's."""
        for row in self.sheet.rows:
            for name in ("grade", "most"):
                if found := re.search(r"\d([.,])\d", self.cell(row, name)):
                    return found[1]
        header = self.sheet.header[self.columns["grade"]].casefold()
        return "," if header == _COLUMNS["grade"][1] else "."


def is_worksheet(path: Path) -> bool:
    """Say whether a file is a grading worksheet, by its headers."""
    try:
        sheet = csv_table.read(path)
    except BatchError:
        return False
    return all(csv_table.column(sheet.header, _COLUMNS[each]) >= 0 for each in ("id", "grade"))


def read(path: Path) -> Worksheet:
    """Read a worksheet. Raises BatchError, with the cure."""
    sheet = csv_table.read(path)
    columns = {name: csv_table.column(sheet.header, known) for name, known in _COLUMNS.items()}
    if columns["id"] < 0 or columns["grade"] < 0:
        raise BatchError("batch.not_a_worksheet", path=path)
    worksheet = Worksheet(path, sheet, columns)
    seen: dict[str, int] = {}
    for line, row in zip(sheet.lines, sheet.rows, strict=True):
        if (number := worksheet.participant(row)) in seen:
            raise BatchError(
                "batch.worksheet_twice", path=path, line=line, first=seen[number], number=number
            )
        seen |= {number: line} if number else {}
    return worksheet


def read_moment(text: str) -> datetime | None:
    """Return a date as Moodle writes it, in French or English; None when it is none."""
    found = _DAY_FIRST.search(text) or _MONTH_FIRST.search(text)
    if not found:
        return None
    name = found["month"].casefold()
    month = next((k for k, names in enumerate(_MONTHS, 1) if name in names), 0)
    hour = int(found["hour"])
    if found["half"]:
        hour = hour % 12 + (12 if found["half"].casefold() == "pm" else 0)
    try:
        return datetime(int(found["year"]), month, int(found["day"]), hour, int(found["minute"]))
    except ValueError:
        return None


def filled(worksheet: Worksheet, marks: Sequence[Mark]) -> tuple[bytes, list[Message]]:
    """Return the worksheet with the marks, and what Moodle will pass over or was cut."""
    by_number = {each.member.moodle: each for each in marks if each.member.moodle}
    rows, told = [], []
    for line, row in zip(worksheet.sheet.lines, worksheet.sheet.rows, strict=True):
        mark = by_number.get(worksheet.participant(row))
        cells = [*row, *[""] * (len(worksheet.sheet.header) - len(row))]
        if mark is not None and (mark.value is not None or mark.comment):
            told += _fill(worksheet, cells, line, mark)
        rows.append(tuple(cells))
    return csv_table.written(replace(worksheet.sheet, rows=tuple(rows))), told


def _fill(worksheet: Worksheet, cells: list[str], line: int, mark: Mark) -> list[Message]:
    told, columns = [], worksheet.columns
    values: dict[str, object] = {"line": line, "name": mark.member.name}
    if mark.value is not None:
        value = mark.value
        most = csv_table.number(worksheet.cell(cells, "most"))
        if most is not None and value > most:
            told.append(Message("batch.row_cut", {**values, "most": f"{most:g}"}))
            value = most
        if worksheet.cell(cells, "changeable").casefold() in _NO:
            told.append(Message("batch.row_locked", values))
        elif _has_grade(worksheet, cells):
            told.append(Message("batch.row_changed", values))
        cells[columns["grade"]] = f"{value:.2f}".replace(".", worksheet.decimal)
    if columns["feedback"] >= 0 and mark.comment:
        cells[columns["feedback"]] = html.escape(csv_table.inert(mark.comment), quote=False)
    return told


def _has_grade(worksheet: Worksheet, cells: Sequence[str]) -> bool:
    """Whether Moodle has a grade already: it keeps it when it was given after the download."""
    return bool(worksheet.cell(cells, "grade").strip("- "))


def write_feedback(path: Path, folders: Mapping[str, Path]) -> None:
    """Write the archive of feedback files: for each name of a Moodle folder, a student's page."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, folder in sorted(folders.items()):
            # ZipInfo's own date: the bytes depend on the pages alone.
            entry = zipfile.ZipInfo(f"{name}/{_FEEDBACK}")
            entry.external_attr = 0o100644 << 16
            archive.writestr(entry, (folder / _FEEDBACK).read_bytes(), zipfile.ZIP_DEFLATED)
    write_whole(path, content.getvalue())


def folder_name(label: str, number: str) -> str:
    """Return the name of a person's folder, as Moodle's own archive has it."""
    return f"{label.replace('_', ' ')}_{number}_assignsubmission_file_"
