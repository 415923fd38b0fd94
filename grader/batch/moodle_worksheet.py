"""Moodle's offline grading worksheet, as it was downloaded: who is in the class, and their dates.

What is known of Moodle's importer, and where from, stands in grader/batch/MOODLE.md.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from functools import cached_property
from pathlib import Path

from grader.batch import csv_table
from grader.batch.csv_table import Sheet
from grader.batch.moodle_archive import FOLDER
from grader.batch.moodle_dates import read_moment
from grader.batch.records import BatchError, Enrolled
from grader.course.message import Message

COLUMNS = {
    "id": ("identifier", "identifiant"),
    "name": ("full name", "nom complet"),
    "number": ("id number", "numéro d'identification"),
    "status": ("status", "statut"),
    "group": ("group", "groupe"),
    "due": ("due date", "date limite"),
    "grade": ("grade", "note"),
    "most": ("maximum grade", "note maximale"),
    "scale": ("scale", "barème"),
    "changeable": ("grade can be changed", "la note peut être modifiée"),
    "handed": (
        "last modified (submission)",
        "dernière modification (travail remis)",
        "dernière modification (remise)",
    ),
    "online": ("online text", "texte en ligne"),
    "graded": ("last modified (grade)", "dernière modification (note)"),
    "feedback": ("feedback comments", "feedback par commentaires", "commentaires de feedback"),
}
_LATE = re.compile(r"\blate\b|\ben retard\b")
_NOT_HANDED = ("no submission", "pas de travail remis")  # "overdue" is no lateness of a work
_DRAFT = ("draft", "brouillon")
_PARTICIPANT = re.compile(r"\D*?(\d+)\s*")
_LEAST_COLUMNS = 5  # of a worksheet in whatever language


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

    @cached_property
    def enrolled(self) -> list[Enrolled]:
        """The persons of the worksheet; without names when marking is anonymous.

        Raises BatchError for a date that is not understood: lateness hangs on it.
        """
        rows = zip(self.sheet.lines, self.sheet.rows, strict=True)
        return [
            self._person(at, line, row)
            for at, (line, row) in enumerate(rows)
            if self.participant(row)
        ]

    def _person(self, at: int, line: int, row: Sequence[str]) -> Enrolled:
        status = csv_table.plain(self.cell(row, "status"))
        return Enrolled(
            self.participant(row),
            self.cell(row, "name") or self.cell(row, "id"),
            self.cell(row, "number"),
            group=self.cell(row, "group"),
            row=at,
            handed=self._moment(line, self.cell(row, "handed")),
            due=self._moment(line, self.cell(row, "due")),
            extended=read_moment(status),
            late=not status.startswith(_NOT_HANDED) and bool(_LATE.search(status)),
            draft=status.startswith(_DRAFT),
            online=bool(self.cell(row, "online")),
        )

    def _moment(self, line: int, text: str) -> datetime | None:
        if text in ("", "-"):
            return None
        moment = read_moment(text)
        if moment is None:
            raise BatchError("batch.worksheet_date", path=self.path, line=line, text=text)
        return moment

    def most(self, row: Sequence[str]) -> float | None:
        """Return the maximum of a row; None when the worksheet does not say it."""
        return csv_table.number(self.cell(row, "most"))

    @property
    def decimal(self) -> str:
        """The decimal sign: that of the numbers that stand there; else the language's."""
        for row in self.sheet.rows:
            for name in ("grade", "most"):
                if found := re.search(r"\d([.,])\d", self.cell(row, name)):
                    return found[1]
        header = csv_table.plain(self.sheet.header[self.columns["grade"]])
        return "," if header == COLUMNS["grade"][1] else "."

    def unused(self) -> Iterator[Message]:
        """Yield what is in the worksheet and is not used."""
        known = {*self.columns.values()}
        others = [each for at, each in enumerate(self.sheet.header) if at not in known and each]
        if others:
            yield Message("batch.unused_columns", {"names": ", ".join(others)})
        for line, row in zip(self.sheet.lines, self.sheet.rows, strict=True):
            if not self.participant(row) and any(cell.strip() for cell in row):
                yield Message("batch.unused_row", {"line": line, "text": self.cell(row, "id")})
        if self.columns["graded"] < 0:
            yield Message("batch.no_grade_date")
        if self.columns["most"] < 0:
            yield Message("batch.no_maximum")


def read(path: Path) -> Worksheet:
    """Read a worksheet. Raises BatchError, with the cure."""
    sheet = csv_table.read(path)
    columns = {name: csv_table.column(sheet.header, known) for name, known in COLUMNS.items()}
    if columns["id"] < 0 or columns["grade"] < 0:
        key = "batch.worksheet_language" if _is_foreign(sheet) else "batch.not_a_worksheet"
        raise BatchError(key, path=path)
    worksheet = Worksheet(path, sheet, columns)
    _verify_points(worksheet)
    seen: dict[str, int] = {}
    for line, row in zip(sheet.lines, sheet.rows, strict=True):
        if (number := worksheet.participant(row)) in seen:
            raise BatchError(
                "batch.worksheet_twice", path=path, line=line, first=seen[number], number=number
            )
        seen |= {number: line} if number else {}
    if not seen:
        raise BatchError("batch.worksheet_nobody", path=path)
    return worksheet


def _verify_points(worksheet: Worksheet) -> None:
    """Raise BatchError when the grades of a worksheet are words, not points."""
    rows = [row for row in worksheet.sheet.rows if worksheet.participant(row)]
    words = worksheet.columns["scale"] >= 0 and worksheet.columns["most"] < 0
    if worksheet.columns["most"] >= 0:
        words = any(not (worksheet.most(row) or 0) > 0 for row in rows)
    if words:
        raise BatchError("batch.scale_of_words", path=worksheet.path)


def beside(folder: Path, leave: Sequence[str]) -> tuple[list[Path], list[Path]]:
    """Return the worksheets of a folder, and the other tables. Raises BatchError.

    A worksheet of a language that is not known, or one that lacks a column, is no other table.
    """
    found, others = [], []
    for path in sorted(folder.glob("*.csv")):
        # What bears a participant's name is theirs, in Moodle's layout without folders.
        if path.name in leave or path.name.startswith(".") or FOLDER.match(path.name):
            continue
        try:
            sheet = csv_table.read(path)
        except BatchError:
            others.append(path)
            continue
        has = {name: csv_table.column(sheet.header, COLUMNS[name]) >= 0 for name in COLUMNS}
        if has["id"] or _is_foreign(sheet):
            found.append(path)
        else:
            others.append(path)
    return found, others


def _is_foreign(sheet: Sheet) -> bool:
    """Whether a table is a worksheet in another language: by the kind of its columns.

    The first column numbers participants; another has dates, or "-" for want of one.
    """
    rows = [row for row in sheet.rows if any(cell.strip() for cell in row)]
    if len(sheet.header) < _LEAST_COLUMNS or not rows:
        return False
    numbers = [_PARTICIPANT.fullmatch(row[0].strip()) for row in rows]
    if not all(numbers) or all(row[0].strip().isdecimal() for row in rows):
        return False
    return any(
        all(len(row) > at and (row[at].strip() == "-" or _DATED.search(row[at])) for row in rows)
        for at in range(1, len(sheet.header))
    )


_DATED = re.compile(r"\b\d{4}\b.*\d{1,2}[:h.]\d{2}|\d{1,2}[:h.]\d{2}.*\b\d{4}\b")


def with_rows(worksheet: Worksheet, rows: Sequence[Sequence[str]]) -> Sheet:
    """Return the table of a worksheet with other rows."""
    return replace(worksheet.sheet, rows=tuple(tuple(row) for row in rows))
