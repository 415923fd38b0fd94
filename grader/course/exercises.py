"""The manifest, exercises.toml: everything about the exercises, read once."""

from __future__ import annotations

import re
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from pathlib import Path
from typing import Any

if sys.version_info >= (3, 11):
    import tomllib
else:
    # Absent, and not needed, from Python 3.11 on.
    import tomli as tomllib  # type: ignore[import-not-found, unused-ignore]

from grader.course.message import GraderError

PACKAGE = Path(__file__).resolve().parent.parent
ROOT = PACKAGE.parent
CORE = ROOT / "core_c"
MANIFEST = PACKAGE / "course" / "exercises.toml"
EXPECTED = ROOT / "reference" / "expected"  # the course's own expected data


_LISTS = {"suites", "compares", "things"}
_LINE = {*_LISTS, "helper", "picture"}
_KEYS = {*_LINE, "weight", "function", "twin", "needs", "judges", "waits", "blames", "proven"}

# The ids that todo_note in core_c/scene.c has a byte for.
_ID = re.compile(r"TP[1-8]\.B?[1-7]")


class ManifestError(GraderError):
    """A file of the grader cannot be read, or contradicts itself: not the student's fault."""


@dataclass(frozen=True)
class Line:
    """How a check looks that has no code of its own: see checks/lines.py."""

    suites: tuple[str, ...] = ()  # of stored calls
    compares: tuple[str, ...] = ()  # parts of their answers, such as "result", "r.tmax"
    helper: str = ""  # a function of checks/ that looks at them, such as "solids.check_meets"
    picture: str = ""  # such as "scene4.shadows"
    things: tuple[str, ...] = ()  # of the picture, that alone count


@dataclass(frozen=True)
class Check:
    """One check of an exercise; points in hundredths, a part of the exercise's."""

    id: str
    exercise: str
    points: int
    function: str  # the one that it calls: of several, not always the exercise's first
    twin: str = ""  # the check without which this one earns nothing
    needs: tuple[str, ...] = ()  # exercises whose functions right code calls in this check
    judges: tuple[str, ...] = ()  # exercises among them whose functions this check judges too
    waits: tuple[str, ...] = ()  # bonuses and later exercises that it cannot be judged without
    blames: tuple[str, ...] = ()  # later exercises among them: waited for when wrong, not as stubs
    proven: Mapping[str, str] = field(default_factory=dict)  # by function: the check that tells
    line: Line | None = None  # None: its test stands in checks/

    @property
    def is_picture(self) -> bool:
        """Whether it judges a picture, which says too little of the code that drew it."""
        return self.line is not None and bool(self.line.picture)

    @property
    def subject(self) -> str:
        """What it judges: a function, a part of an exercise, or "scene"."""
        return subject(self.id)


@dataclass(frozen=True)
class Exercise:
    """One exercise of the workbook; points in hundredths."""

    id: str
    tp: int
    functions: tuple[str, ...]
    file: str
    points: int
    bonus: bool
    section: str
    depends: tuple[str, ...]
    checks: tuple[Check, ...]
    suites: Mapping[str, Mapping[str, Any]]  # that are lines: authoring/expected/vectors/lines.py


@dataclass(frozen=True)
class Manifest:
    """All the exercises in order, and whose file is whose."""

    exercises: tuple[Exercise, ...]
    student: tuple[str, ...]
    given: tuple[str, ...]
    ungraded: tuple[str, ...]

    def total(self, *, bonus: bool) -> float:
        """Return the points of all exercises, or of all bonuses."""
        return sum(each.points for each in self.exercises if each.bonus is bonus) / 100

    @cached_property
    def tps(self) -> tuple[int, ...]:
        """The numbers of the TPs."""
        return tuple(sorted({each.tp for each in self.exercises}))

    def checks(self) -> Mapping[str, Check]:
        """Return every check by its id."""
        return self._checks

    def exercise(self, name: str) -> Exercise:
        """Return the exercise of that id. Raises KeyError."""
        return self._exercises[name]

    @cached_property
    def _checks(self) -> Mapping[str, Check]:
        return {check.id: check for each in self.exercises for check in each.checks}

    @cached_property
    def _exercises(self) -> Mapping[str, Exercise]:
        return {each.id: each for each in self.exercises}

    def needed(self, check: Check) -> frozenset[str]:
        """Return the exercises that a check needs, and those that they depend on, but its own."""
        found: set[str] = set()
        waiting = list(check.needs)
        while waiting:
            name = waiting.pop()
            if name not in found:
                found.add(name)
                waiting += self.exercise(name).depends
        return frozenset(found) - {check.exercise}

    def waited_for(self, check: Check) -> frozenset[str]:
        """Return the exercises that a check may wait for: on the way to its own, and no bonus."""
        own = self.exercise(check.exercise)
        before = (self.exercise(each) for each in self.needed(check))
        core = {each.id for each in before if not each.bonus and each.tp <= own.tp}
        return frozenset(core | {*check.waits})


def subject(check: str) -> str:
    """Return what the check of that id judges: the middle of "tp2.intersect_sphere.hits"."""
    return check.split(".")[1]


def read_toml(path: Path) -> dict[str, Any]:
    """Read a TOML file of the grader. Raises ManifestError, naming the file and the cure."""
    try:
        table: dict[str, Any] = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise ManifestError(f"{path.name}: {error}; put the original file back") from error
    return table


def malformed(path: Path, error: Exception) -> ManifestError:
    """Return the error of a table that lacks something, or has it in another form."""
    return ManifestError(f"{path.name}: missing or malformed key: {error}")


@cache
def load(path: Path = MANIFEST) -> Manifest:
    """Read the manifest. Raises ManifestError."""
    data = read_toml(path)
    try:
        files = data["files"]
        manifest = Manifest(
            exercises=tuple(_exercise(row) for row in data["exercise"]),
            student=tuple(files["student"]),
            given=tuple(files["given"]),
            ungraded=tuple(files["ungraded"]),
        )
    except (KeyError, TypeError, ValueError) as error:
        raise malformed(path, error) from error
    _verify(manifest, path)
    return manifest


def shares(points: int, weights: list[int]) -> list[int]:
    """Split points by weights into integers of the same sum: rest to the largest remainders."""
    total = sum(weights)
    parts = [points * weight // total for weight in weights]
    order = sorted(range(len(weights)), key=lambda k: -(points * weights[k] % total))
    for k in order[: points - sum(parts)]:
        parts[k] += 1
    return parts


def _exercise(row: dict[str, Any]) -> Exercise:
    rules = row.get("checks", {})
    points = shares(row["points"], [rule["weight"] for rule in rules.values()]) if rules else []
    return Exercise(
        id=row["id"],
        tp=row["tp"],
        functions=tuple(row["functions"]),
        file=row["file"],
        points=row["points"],
        bonus=row["bonus"],
        section=row["section"],
        depends=tuple(row["depends"]),
        checks=tuple(
            Check(
                name,
                row["id"],
                share,
                rule.get("function") or _called(name, row["functions"]),
                rule.get("twin", ""),
                tuple(rule.get("needs", row["depends"])),
                tuple(rule.get("judges", ())),
                tuple(rule.get("waits", ())),
                tuple(rule.get("blames", ())),
                dict(rule.get("proven", {})),
                _line(name, rule),
            )
            for (name, rule), share in zip(rules.items(), points, strict=True)
        ),
        suites=row.get("suites", {}),
    )


def _line(check: str, rule: Mapping[str, Any]) -> Line | None:
    """Return how a check looks; None when it has code. Raises ValueError."""
    if unknown := sorted(set(rule) - _KEYS):
        raise ValueError(f"{check} has an unknown key, {unknown[0]}")
    ways = [name for name in ("compares", "helper", "picture") if name in rule]
    if len(ways) > 1:
        raise ValueError(f"{check} has {' and '.join(ways)}: keep one")
    if bool(rule.get("suites")) != (ways in (["compares"], ["helper"])):
        raise ValueError(f"{check}: suites go with compares or helper")
    own: dict[str, Any] = {name: rule[name] for name in _LINE if name in rule}
    for name in _LISTS & own.keys():
        if not isinstance(own[name], list):
            raise ValueError(f"{check}: {name} is a list")
        own[name] = tuple(own[name])
    return Line(**own) if own else None


def _called(check: str, functions: list[str]) -> str:
    """Return the function that a check is named after; of the others, the exercise's first."""
    subject = check.split(".")[1]
    return subject if subject in functions else functions[0]


def _verify(manifest: Manifest, path: Path) -> None:
    ids = [each.id for each in manifest.exercises]
    checks = [check for each in manifest.exercises for check in each.checks]
    known = {check.id for check in checks}
    wrong = [each for each in ids if ids.count(each) > 1 or not _ID.fullmatch(each)]
    wrong += [name for each in manifest.exercises for name in each.depends if name not in ids]
    wrong += [check.twin for check in checks if check.twin and check.twin not in known]
    wrong += [name for check in checks for name in check.needs if name not in ids]
    wrong += [
        name
        for check in checks
        for name in (*check.judges, *check.blames)
        if name not in check.needs
    ]
    wrong += [name for check in checks for name in check.waits if name not in ids]
    wrong += [name for check in checks for name in check.proven.values() if name not in known]
    wrong += [
        check.function
        for each in manifest.exercises
        for check in each.checks
        if check.function not in each.functions
    ]
    if len(known) != len(checks):
        wrong.append("a check stands twice")
    if wrong:
        what = "unknown, repeated, or no id from TP1.1 to TP8.7 and TP8.B7"
        raise ManifestError(f"{path.name}: {what}: {', '.join(wrong)}")
