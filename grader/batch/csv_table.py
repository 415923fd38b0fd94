"""CSV files of unknown dialect, read and written back alike; cells that no spreadsheet obeys."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from grader.batch.records import BatchError

MAX_BYTES = 20_000_000
_BOM = b"\xef\xbb\xbf"
_DELIMITERS = ",;\t"
_ANNOUNCED = re.compile(r'"?sep=(.)"?[ \t]*\r?\n', re.IGNORECASE)  # by Excel, for Excel
_NUMBER = re.compile(r"-?\d+(?:[.,]\d+)?")


@dataclass(frozen=True)
class Sheet:
    """A table of text, and how its file is written. `lines` are where its rows begin.

    It is written in UTF-8, which platforms expect unless told; with its mark (`bom`) where the file
    was in another encoding, so that a spreadsheet reads it too.
    """

    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    lines: tuple[int, ...]
    delimiter: str = ","
    bom: bool = False
    newline: str = "\n"
    quoted: bool = False  # every cell


def read(path: Path) -> Sheet:
    """Read a table. Raises BatchError, naming the file and the cure."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise BatchError("batch.cannot_read", path=path, error=error.strerror) from error
    if len(content) > MAX_BYTES:
        raise BatchError("batch.not_a_table", path=path)
    text, bom = _decoded(content)
    delimiter, before = "", 0
    if announced := _ANNOUNCED.match(text):
        delimiter, before, text = announced[1], 1, text[announced.end() :]
    first = text.splitlines()[0] if text.strip() else ""
    outside = re.sub(r'"[^"]*"', "", first)
    delimiter = delimiter or max(_DELIMITERS, key=outside.count)
    rows, lines = _rows(text, delimiter, path)
    newline = "\r\n" if "\r\n" in text else "\n"
    header = tuple(each.strip() for each in rows[0])
    quoted = first.count('"') >= 2 * len(header)
    places = tuple(line + before for line in lines[1:])
    return Sheet(header, tuple(rows[1:]), places, delimiter, bom, newline, quoted)


def _decoded(content: bytes) -> tuple[str, bool]:
    """Return a text, and whether it is written with UTF-8's mark."""
    if content.startswith(_BOM):
        return content.removeprefix(_BOM).decode("utf-8", errors="replace"), True
    wide = ""
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        wide = "utf-16"
    elif b"\0" in content[:2]:
        wide = "utf-16-be" if content[:1] == b"\0" else "utf-16-le"
    if wide:  # Excel's "Unicode text"
        return content.decode(wide, errors="replace"), True
    try:
        return content.decode("utf-8"), False
    except UnicodeDecodeError:
        return content.decode("cp1252", errors="replace"), True


def _rows(text: str, delimiter: str, path: Path) -> tuple[list[tuple[str, ...]], list[int]]:
    """Return the rows of a table, the header too, and the lines where they begin."""
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter)
    rows, lines, line = [], [], 1
    try:
        for row in reader:
            rows.append(tuple(row))
            lines.append(line)
            line = reader.line_num + 1
    except csv.Error as error:
        raise BatchError("batch.not_a_table", path=path) from error
    if not rows:
        raise BatchError("batch.not_a_table", path=path)
    return rows, lines


def written(sheet: Sheet) -> bytes:
    """Return the content of a table's file."""
    out = io.StringIO(newline="")
    writer = csv.writer(
        out,
        delimiter=sheet.delimiter,
        lineterminator=sheet.newline,
        quoting=csv.QUOTE_ALL if sheet.quoted else csv.QUOTE_MINIMAL,
    )
    writer.writerow(sheet.header)
    writer.writerows(sheet.rows)
    content = out.getvalue().encode()
    return _BOM + content if sheet.bom else content


def inert(text: str) -> str:
    """Return text as a cell that a spreadsheet shows and does not run, on one line."""
    line = one_line(text)
    if _NUMBER.fullmatch(line):
        return line
    return f"'{line}" if line[:1] in ("=", "+", "-", "@", "|", "%") else line


def one_line(text: str) -> str:
    """Return text without what is no sign, such as ends of lines."""
    return "".join(each if each.isprintable() else " " for each in text).strip()


def number(text: str) -> float | None:
    """Return a number written with a comma or a point; None when it is none."""
    digits = re.sub(r"[\s\u00a0\u202f]", "", text)
    return float(digits.replace(",", ".")) if _NUMBER.fullmatch(digits) else None


def column(header: Sequence[str], names: Sequence[str]) -> int:
    """Return the index of the column of one of these names, in small letters; -1 without."""
    for at, each in enumerate(header):
        if plain(each) in names:
            return at
    return -1


def plain(heading: str) -> str:
    """Return a heading in small letters, with a typewriter's apostrophes and spaces."""
    return " ".join(heading.casefold().replace("\u2019", "'").split())
