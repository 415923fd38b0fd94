"""grades.csv, one line for each person; marks.json; and what changed since the last run."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from grader.batch.csv_table import Sheet, inert, written
from grader.batch.records import Graded, Mark
from grader.batch.roster import key_of
from grader.course import exercises as manifest
from grader.course.texts import Texts

GRADES, CHANGES, MARKS = "grades.csv", "changes.csv", "marks.json"
_FIELDS = ("name", "number", "participant", "submission", "pseudonym", "mark", "points", "bonus")
_AFTER = ("rubric", "days_late", "penalty", "comment", "remarks")


def pseudonyms(marks: Sequence[Mark]) -> dict[str, str]:
    """Return a name that says nothing for each submission: their order is that of their names."""
    names = sorted({each.member.submission for each in marks if each.member.submission})
    return {name: f"S{number:03d}" for number, name in enumerate(names, 1)}


def grades(marks: Sequence[Mark], graded: Mapping[str, Graded], texts: Texts) -> bytes:
    """Return grades.csv: what spreadsheets of the language open by a double click."""
    exercises = [each.id for each in manifest.load().exercises]
    header = [texts.say(f"heading.{name}") for name in _FIELDS] + exercises
    header += [texts.say(f"heading.{name}") for name in _AFTER]
    hidden = pseudonyms(marks)
    rows = [_row(each, graded, exercises, hidden, texts) for each in marks]
    return _table(header, rows, texts)


def _row(
    mark: Mark,
    graded: Mapping[str, Graded],
    exercises: Sequence[str],
    hidden: Mapping[str, str],
    texts: Texts,
) -> list[str]:
    member = mark.member
    known = graded.get(member.submission)
    results = known.results if known and known.results else {"exercises": {}}
    counted = mark.value is not None and bool(results["exercises"])
    numbers = (mark.points, mark.bonus) if counted else (None, None)
    after = (mark.rubric, mark.late_days, mark.penalty) if counted else (None, None, None)
    earned = [results["exercises"].get(name) for name in exercises]
    return [
        inert(member.name),
        inert(member.number),
        inert(member.moodle),
        inert(member.submission),
        hidden.get(member.submission, ""),
        *(_number(each, texts) for each in (mark.value, *numbers)),
        *(_number(each[1] if each else None, texts) for each in earned),
        *(_number(each, texts) for each in after),
        inert(mark.comment),
        inert(" ".join(sentence(mark, texts))),
    ]


def sentence(mark: Mark, texts: Texts) -> list[str]:
    """Return what is to be known of a mark."""
    return list(dict.fromkeys(texts.say(each.key, **each.values) for each in mark.why))


def _number(value: float | None, texts: Texts) -> str:
    return "" if value is None else texts.number(round(value, 3))


def _table(header: Sequence[str], rows: Sequence[Sequence[str]], texts: Texts) -> bytes:
    # A French spreadsheet takes a comma for the decimal sign; the mark of UTF-8 is for Excel.
    delimiter = ";" if texts.language == "fr" else ","
    lines = tuple(range(2, len(rows) + 2))
    table = tuple(tuple(row) for row in rows)
    return written(Sheet(tuple(header), table, lines, delimiter, bom=True, newline="\r\n"))


# ---- What changed since the last run ------------------------------------------------------------


def kept(marks: Sequence[Mark], graded: Mapping[str, Graded], common: str) -> dict[str, Any]:
    """Return the content of marks.json: each mark, and what it came of."""
    found: dict[str, Any] = {}
    for mark in marks:
        known = graded.get(mark.member.submission)
        # Numbers may be known to one run only, through a worksheet; the name is always there.
        member = mark.member
        key = f"{member.submission or member.moodle} / {key_of(member.name)}"
        found[key] = {
            "name": mark.member.name,
            "mark": mark.value,
            "parts": {
                **(known.parts if known else {}),
                "course": common,
                "manual": mark.comment + f"{mark.rubric:g}" + repr(mark.why if not known else ""),
                "late": f"{mark.late_days} {mark.penalty:g}",
                "error": repr(mark.error),
            },
        }
    return found


def changes(before: Mapping[str, Any], now: Mapping[str, Any], texts: Texts) -> list[list[str]]:
    """Return the lines of changes.csv: who, old mark, new mark, why."""
    rows = []
    for key, new in now.items():
        old = before.get(key)
        if old is None or old["mark"] == new["mark"]:
            continue
        parts = {*old["parts"], *new["parts"]}
        other = [
            texts.say(f"why.{part}")
            for part in sorted(parts)
            if old["parts"].get(part) != new["parts"].get(part)
        ]
        numbers = [_number(each["mark"], texts) for each in (old, new)]
        rows.append([inert(new["name"]), *numbers, ", ".join(other) or texts.say("why.chance")])
    return rows


def changes_table(rows: Sequence[Sequence[str]], texts: Texts) -> bytes:
    """Return changes.csv."""
    header = [texts.say(f"heading.{name}") for name in ("name", "before", "mark", "why")]
    return _table(header, rows, texts)


def read_kept(out: Path) -> dict[str, Any]:
    """Return the marks of the last run; none when there was none, or they cannot be read."""
    try:
        content: dict[str, Any] = json.loads((out / MARKS).read_text(encoding="utf-8"))
        if all(isinstance(each["parts"], dict) and "mark" in each for each in content.values()):
            return content
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        pass
    return {}
