"""manual.csv, beside the submissions: what only a person can judge, kept by every regrade.

    who;drawing;style;comment;override;reason
    21905678;1,5;0,5;"A fine drawing";;
    Ada Lovelace;;;;14;"oral examination of 3 March"

`who` is a student number, a name, or the name of a submission (then it counts for its members). Any
other column is one of points, in the unit of the scale, which are added to the mark.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from grader.batch import csv_table
from grader.batch.csv_table import Sheet
from grader.batch.names import key_of
from grader.batch.records import BatchError, ManualMark, Member

NAME = "manual.csv"
_WHO = ("who", "qui")
_COMMENT = ("comment", "commentaire")
_OVERRIDE = ("override", "note imposée")
_REASON = ("reason", "raison")


def read(path: Path, members: Sequence[Member], scale: float) -> dict[Member, ManualMark]:
    """Return what is said of each member. Raises BatchError with the line and the cure."""
    if not path.exists():
        return {}
    sheet = csv_table.read(path)
    who = csv_table.column(sheet.header, _WHO)
    if who < 0:
        raise BatchError("batch.manual_header", path=path, names=", ".join(_WHO))
    found: dict[Member, ManualMark] = {}
    for line, row in zip(sheet.lines, sheet.rows, strict=True):
        if not any(cell.strip() for cell in row):
            continue
        if len(row) > len(sheet.header):
            raise BatchError("batch.manual_cells", path=path, line=line, count=len(sheet.header))
        cells = {name: cell.strip() for name, cell in zip(sheet.header, row, strict=False)}
        hand = _hand(sheet, cells, path, line, scale)
        for member in _meant(cells[sheet.header[who]], members, path, line):
            if member in found:
                raise BatchError(
                    "batch.manual_twice", path=path, line=line, first=found[member].line
                )
            found[member] = hand
    return found


def _hand(
    sheet: Sheet, cells: Mapping[str, str], path: Path, line: int, scale: float
) -> ManualMark:
    def named(names: Sequence[str]) -> str:
        at = csv_table.column(sheet.header, names)
        return cells.get(sheet.header[at], "") if at >= 0 else ""

    known = (*_WHO, *_COMMENT, *_OVERRIDE, *_REASON)
    points = {
        name: _points(cells[name], name, path, line)
        for name in sheet.header
        if name.casefold() not in known and cells.get(name)
    }
    override, reason = named(_OVERRIDE), named(_REASON)
    value = _points(override, _OVERRIDE[0], path, line) if override else None
    if value is not None and not 0 <= value <= scale:
        raise BatchError("batch.manual_range", path=path, line=line, scale=float(scale))
    if value is not None and not reason:
        raise BatchError("batch.manual_reason", path=path, line=line)
    return ManualMark(line, points, named(_COMMENT), value, reason)


def _points(cell: str, column: str, path: Path, line: int) -> float:
    value = csv_table.number(cell)
    if value is None:
        raise BatchError("batch.manual_number", path=path, line=line, column=column, cell=cell)
    return value


def _meant(who: str, members: Sequence[Member], path: Path, line: int) -> list[Member]:
    """Return those whom a line is about: one person by number or by name, or a submission's."""
    numbered = [each for each in members if who and who in (each.number, each.moodle)]
    theirs = [each for each in members if who and who == each.submission and not each.unsettled]
    named = [each for each in members if key_of(who) and key_of(who) == key_of(each.name)]
    if numbered:
        found = numbered[:1]
        doubtful = len(numbered) > 1
    else:
        found = theirs or named[:1]
        doubtful = not set(named) <= set(theirs) if theirs else len(named) > 1
    if not found:
        raise BatchError("batch.manual_nobody", path=path, line=line, who=who)
    if doubtful:
        raise BatchError("batch.manual_several", path=path, line=line, who=who)
    return found
