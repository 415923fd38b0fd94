"""marks.xlsx: the rows of grades.csv for who works in Excel; where openpyxl is installed."""

from __future__ import annotations

import importlib.util
import io
import zipfile
from collections.abc import Mapping, Sequence
from typing import Any

from grader.batch.csv_table import one_line
from grader.batch.grades_csv import Cell, cells
from grader.batch.records import Graded, Mark
from grader.course.texts import Texts

NAME = "marks.xlsx"
WIDEST = 60  # characters of a column
_TEXT = "@"  # the format of cells that stay text, whatever is typed into them


def is_possible() -> bool:
    """Whether the package that writes such files is here: an extra, requirements/sheet.txt."""
    return importlib.util.find_spec("openpyxl") is not None


def marks_sheet(
    marks: Sequence[Mark], graded: Mapping[str, Graded], hidden: Mapping[str, str], texts: Texts
) -> bytes:
    """Return the file: numbers are numbers, and a text that looks like a formula is a text."""
    from openpyxl import Workbook  # type: ignore[import-untyped]
    from openpyxl.styles import Font  # type: ignore[import-untyped]
    from openpyxl.writer.excel import ExcelWriter  # type: ignore[import-untyped]

    book = Workbook()
    sheet = book.active
    sheet.title = texts.say("class.marks")
    header, rows = cells(marks, graded, hidden, texts)
    lines: list[Sequence[Cell]] = [header, *rows]
    for number, row in enumerate(lines, 1):
        for column, value in enumerate(row, 1):
            _fill(sheet.cell(number, column), value)
    for column in sheet.columns:
        column[0].font = Font(bold=True)
        longest = max(len(str(each.value or "")) for each in column)
        sheet.column_dimensions[column[0].column_letter].width = min(longest + 2, WIDEST)
    sheet.freeze_panes = "B2"
    out = io.BytesIO()
    ExcelWriter(book, _Undated(out, "w", zipfile.ZIP_DEFLATED, strict_timestamps=False)).save()
    return out.getvalue()


class _Undated(zipfile.ZipFile):
    """An archive for any clock: ZIP has no dates before 1980, where a machine's may stand."""

    def writestr(
        self,
        zinfo_or_arcname: Any,
        data: Any,
        compress_type: int | None = zipfile.ZIP_DEFLATED,
        compresslevel: int | None = None,
    ) -> None:
        """Write a file of the first day that there is."""
        name = zinfo_or_arcname
        entry = zipfile.ZipInfo(name) if isinstance(name, str) else name
        super().writestr(entry, data, compress_type, compresslevel)


def _fill(cell: Any, value: Cell) -> None:
    """Write a cell. openpyxl takes a text that begins with = for a formula, unless told."""
    if not isinstance(value, str):
        cell.value = value
        return
    cell.value = one_line(value) or None
    if cell.value is not None:
        cell.data_type = "s"
        cell.number_format = _TEXT
