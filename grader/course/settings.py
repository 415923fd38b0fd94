"""The settings of the course, course.toml, read once.

A second file, beside the submissions of a batch, may have the tables of marks and people again,
in the place of these: names of persons need not stand in a file that is handed out.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from datetime import datetime
from functools import cache
from pathlib import Path
from typing import Any

from grader.course.exercises import PACKAGE, ManifestError, read_toml
from grader.course.exercises import load as load_manifest

COURSE = PACKAGE / "course" / "course.toml"
MESSAGES = PACKAGE / "course" / "messages"  # a folder for each language
COMPLETE = ("fr", "en")  # another one falls back on English
_OTHERS = {each.name for each in MESSAGES.iterdir() if re.fullmatch("[a-z]{2}", each.name)}
LANGUAGES = (*COMPLETE, *sorted(_OTHERS - {*COMPLETE}))
DIALECTS = ("c", "c++")
_GRADING = ("language", "dialect", "opened", "count_closed")
_TABLES = ("marks", "late", "deadlines", "people")


@dataclass(frozen=True)
class Marks:
    """From points to a mark, in units of the scale."""

    scale: float = 20.0
    step: float = 0.25  # marks are rounded to a multiple of it; 0: to a hundredth
    bonus_cap: float = 2.0  # that bonuses can add at most
    weights: Mapping[int, float] = field(default_factory=dict)  # by TP; its points when not said


@dataclass(frozen=True)
class Late:
    """What a late hand-in costs, in units of the scale."""

    per_day: float = 0.0  # for each day begun
    most: float = 20.0
    grace_minutes: float = 0.0
    zero_after_days: float = 0.0  # 0: never


@dataclass(frozen=True)
class People:
    """Settings for one person each, by student number or by name. Times are local."""

    excused: tuple[str, ...] = ()
    extensions: Mapping[str, datetime] = field(default_factory=dict)
    absent: float | None = None  # the mark of who has handed in nothing; None: no mark


@dataclass(frozen=True)
class Course:
    """What an instructor may change."""

    language: str
    dialect: str
    opened: tuple[int, ...]
    count_closed: bool
    marks: Marks = field(default_factory=Marks)
    late: Late = field(default_factory=Late)
    deadlines: Mapping[int, datetime] = field(default_factory=dict)  # by TP; local times
    people: People = field(default_factory=People)

    def is_counted(self, tp: int) -> bool:
        """Say whether a TP is judged, and counted, when nothing else is asked for."""
        return self.count_closed or tp in self.opened

    @property
    def deadline(self) -> datetime | None:
        """When the work is due: that of the last opened TP that has one."""
        due = [tp for tp in self.opened if tp in self.deadlines]
        return self.deadlines[max(due)] if due else None


@cache
def load(path: Path = COURSE) -> Course:
    """Read the settings. Raises ManifestError, naming the file and what is wrong."""
    file = _File(path)
    data = file.data
    known = {"language": LANGUAGES, "dialect": DIALECTS}
    for key, values in known.items():
        if data.get(key) not in values:
            raise file.wrong("", key, f"must be one of {', '.join(values)}")
    opened = data.get("opened")
    tps = load_manifest().tps
    if not isinstance(opened, list) or not set(map(str, opened)) <= set(map(str, tps)):
        raise file.wrong("", "opened", "must be a list of TPs such as [1, 2]")
    count_closed = data.get("count_closed", False)
    if not isinstance(count_closed, bool):
        raise file.wrong("", "count_closed", "must be true or false")
    file.known("", data, (*_GRADING, *_TABLES))
    course = Course(data["language"], data["dialect"], tuple(sorted(opened)), count_closed)
    return _with_tables(course, file)


def beside(course: Course, path: Path) -> Course:
    """Return the course with the tables of a second file. Raises ManifestError."""
    file = _File(path)
    for key in _GRADING:
        if key in file.data:
            raise file.wrong("", key, f"belongs in grader/course/{COURSE.name}; move it there")
    file.known("", file.data, _TABLES)
    return _with_tables(course, file)


def _with_tables(course: Course, file: _File) -> Course:
    makers = {"marks": _marks, "late": _late, "deadlines": _deadlines, "people": _people}
    found = {name: make(file) for name, make in makers.items() if name in file.data}
    return replace(course, **found)  # type: ignore[arg-type]


def _marks(file: _File) -> Marks:
    table = file.table("marks", ("scale", "step", "bonus_cap", "weights"))
    default = Marks()
    weights = table.get("weights", {})
    if not isinstance(weights, dict):
        raise file.wrong("marks", "weights", "must be such as { TP1 = 15, TP2 = 30 }")
    for key, value in weights.items():
        if not _is_number(value) or value < 0:
            raise file.wrong("marks", "weights", f"{key} must be a number from 0 on")
    marks = Marks(
        scale=file.number("marks", "scale", default.scale),
        step=file.number("marks", "step", default.step),
        bonus_cap=file.number("marks", "bonus_cap", default.bonus_cap),
        weights={file.tp("marks", key, "weights"): float(each) for key, each in weights.items()},
    )
    if marks.scale <= 0:
        raise file.wrong("marks", "scale", "must be above 0, such as 20")
    return marks


def _late(file: _File) -> Late:
    names = ("per_day", "most", "grace_minutes", "zero_after_days")
    file.table("late", names)
    return Late(**{name: file.number("late", name, getattr(Late(), name)) for name in names})


def _deadlines(file: _File) -> dict[int, datetime]:
    table = file.table("deadlines")
    return {
        file.tp("deadlines", key): file.moment("deadlines", key, value)
        for key, value in table.items()
    }


def _people(file: _File) -> People:
    table = file.table("people", ("excused", "extensions", "absent"))
    excused = table.get("excused", [])
    if not isinstance(excused, list) or not all(isinstance(each, str) for each in excused):
        raise file.wrong("people", "excused", 'must be a list such as ["21905678", "Ada Lovelace"]')
    extensions = table.get("extensions", {})
    if not isinstance(extensions, dict):
        example = '{ "21905678" = 2026-03-09T23:59:00 }'
        raise file.wrong("people", "extensions", f"must be such as {example}")
    absent = table.get("absent", "none")
    if absent != "none" and not _is_number(absent):
        raise file.wrong("people", "absent", 'must be a mark such as 0, or "none"')
    moments = {
        name: file.moment("people", "extensions", value) for name, value in extensions.items()
    }
    return People(tuple(excused), moments, None if absent == "none" else float(absent))


class _File:
    """A file of settings, and where its keys stand."""

    def __init__(self, path: Path) -> None:
        self.data: dict[str, Any] = read_toml(path)
        self._name = path.name
        self._lines = path.read_text(encoding="utf-8").splitlines()

    def wrong(self, table: str, key: str, why: str) -> ManifestError:
        """Return the error of a key, with its line."""
        line = self._line(table, key)
        place = f"{self._name}, line {line}" if line else self._name
        return ManifestError(f"{place}: {key} {why}")

    def _line(self, table: str, key: str) -> int:
        """Return the number of a key's line; of its table when it has none; 0 without either."""
        here, header = "", 0
        for number, line in enumerate(self._lines, 1):
            if found := re.match(r"\s*\[+\s*([\w.]+)", line):
                here = found[1]
                header = number if here == table else header
            inside = table and here == f"{table}.{key}"
            if inside or (here == table and re.match(rf'\s*"?{re.escape(key)}"?\s*[=.]', line)):
                return number
        return header

    def known(self, table: str, data: Mapping[str, Any], names: tuple[str, ...]) -> None:
        """Raise ManifestError for a key that is not one of these."""
        for key in sorted(set(data) - set(names)):
            raise self.wrong(table, key, f"is unknown here; known: {', '.join(names)}")

    def table(self, name: str, names: tuple[str, ...] = ()) -> dict[str, Any]:
        """Return a table whose keys are among these (any when none is given)."""
        table = self.data[name]
        if not isinstance(table, dict):
            raise self.wrong("", name, f"must be a table: write [{name}] on a line of its own")
        if names:
            self.known(name, table, names)
        return table

    def number(self, table: str, key: str, default: float) -> float:
        """Return a number from 0 on."""
        value = self.data[table].get(key, default)
        if not _is_number(value) or value < 0:
            raise self.wrong(table, key, "must be a number from 0 on")
        return float(value)

    def tp(self, table: str, name: str, key: str = "") -> int:
        """Return the number of a TP's name, such as "TP2"."""
        for number in load_manifest().tps:
            if name == f"TP{number}":
                return number
        names = ", ".join(f"TP{number}" for number in load_manifest().tps)
        raise self.wrong(table, key or name, f"{name} is no TP; there are {names}")

    def moment(self, table: str, key: str, value: object) -> datetime:
        """Return a date and time as the local one."""
        if not isinstance(value, datetime):
            raise self.wrong(table, key, "must be a date and time such as 2026-03-02T23:59:00")
        return value.astimezone().replace(tzinfo=None) if value.tzinfo else value


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
