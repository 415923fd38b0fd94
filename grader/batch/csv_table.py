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
_NUMBER = re.compile(r"-?\d+(?:[.,]\d+)?")


@dataclass(frozen=True)
class Sheet:
    """A table of text, and how its file is written. `lines` are where its rows begin."""

    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    lines: tuple[int, ...]
    delimiter: str = ","
    bom: bool = False
    newline: str = "\n"
    encoding: str = "utf-8"
    quoted: bool = False  # every cell


def read(path: Path) -> Sheet:
    """Read a table. Raises BatchError, naming the file and the cure."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise BatchError("batch.cannot_read", path=path, error=error.strerror) from error
    if len(content) > MAX_BYTES:
        raise BatchError("batch.not_a_table", path=path)
    bom = content.startswith(_BOM)
    encoding = "utf-8"
    try:
        text = content.removeprefix(_BOM).decode("utf-8")
    except UnicodeDecodeError:
        text, encoding = content.decode("cp1252", errors="replace"), "cp1252"
    first = text.splitlines()[0] if text.strip() else ""
    delimiter = max(_DELIMITERS, key=first.count)
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
    newline = "\r\n" if "\r\n" in text else "\n"
    header = tuple(each.strip() for each in rows[0])
    quoted = first.count('"') >= 2 * len(header)
    return Sheet(
        header, tuple(rows[1:]), tuple(lines[1:]), delimiter, bom, newline, encoding, quoted
    )


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
    content = out.getvalue().encode(sheet.encoding, errors="xmlcharrefreplace")
    return _BOM + content if sheet.bom else content


def inert(text: str) -> str:
    """Return text as a cell that a spreadsheet shows and does not run, on one line."""
    plain = "".join(each if each.isprintable() else " " for each in text).strip()
    if _NUMBER.fullmatch(plain):
        return plain
    return f"'{plain}" if plain[:1] in ("=", "+", "-", "@", "|", "%") else plain


def number(text: str) -> float | None:
    """Return a number written with a comma or a point; None when it is none."""
    plain = re.sub(r"[\s\u00a0\u202f]", "", text)
    return float(plain.replace(",", ".")) if _NUMBER.fullmatch(plain) else None


def column(header: Sequence[str], names: Sequence[str]) -> int:
    """Return the index of the column of one of these names, in small letters; -1 without."""
    for at, each in enumerate(header):
        if each.casefold() in names:
            return at
    return -1
