"""marks.json, what a run leaves for the next one; and what has changed since, with the reasons."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from grader.batch.csv_table import inert
from grader.batch.grades_csv import number, table
from grader.batch.names import digits_of, is_alike, is_named, key_of
from grader.batch.records import Graded, ManualMark, Mark, Member
from grader.course.settings import Course
from grader.course.texts import Texts

CHANGES, MARKS = "changes.csv", "marks.json"
_TABLES = {"people": list, "grades": dict, "comments": dict, "pages": dict}
_RESULT = ("sources", "grader", "expected", "settings")  # what a result depends on


def person_of(member: Member) -> dict[str, str]:
    """Return what a person is known by from one run to the next."""
    return {"name": member.name, "number": member.number, "moodle": member.moodle}


def is_same(one: Mapping[str, str], other: Mapping[str, str]) -> bool:
    """Say whether two runs speak of one person. Each may know other numbers than the other."""
    alike = is_alike(one["name"], other["name"])
    if one["moodle"] and other["moodle"]:
        return one["moodle"] == other["moodle"] and (
            alike or "" in (one["number"], other["number"])
        )
    if one["number"] and other["number"]:
        return digits_of(one["number"]) == digits_of(other["number"])
    return key_of(one["name"]) == key_of(other["name"])


def kept(
    marks: Sequence[Mark],
    graded: Mapping[str, Graded],
    hands: Mapping[Member, ManualMark],
    course: Course,
) -> list[Any]:
    """Return each mark, and what it came of."""
    return [
        {
            **person_of(each.member),
            "mark": each.value,
            "parts": {
                **_of_submission(each, graded.get(each.member.submission)),
                **_of_person(each, hands.get(each.member), course),
            },
        }
        for each in marks
    ]


def _of_submission(mark: Mark, known: Graded | None) -> dict[str, str]:
    problem = known.candidate.problem if known else None
    return {
        **{part: known.parts[part] for part in _RESULT if known and part in known.parts},
        "problem": repr(problem),
        "authors": repr((mark.member.submission, mark.member.unsettled)),
        "error": repr(mark.error),
    }


def _of_person(mark: Mark, hand: ManualMark | None, course: Course) -> dict[str, str]:
    member, people = mark.member, course.people
    row = member.enrolled
    excused = any(is_named(member, each) for each in people.excused)
    extended = [people.extensions[each] for each in people.extensions if is_named(member, each)]
    rules = (course.marks, course.late, course.deadlines, course.opened, people.absent)
    facts = (row.handed, row.due, row.extended, row.group, row.row >= 0) if row else ()
    return {
        "course": repr(rules),
        "people": repr((excused, extended)),
        "worksheet": repr((member.handed, *facts)),
        "manual": repr(hand and (hand.rubric, hand.comment, hand.override, hand.reason)),
        "late": f"{mark.late_days} {mark.penalty:g}",
    }


def changes(
    before: Sequence[Mapping[str, Any]], now: Sequence[Mapping[str, Any]], texts: Texts
) -> list[list[str]]:
    """Return the lines of changes.csv: who, old mark, new mark, why."""
    left = list(before)
    rows = []
    for new in now:
        old = next((each for each in left if is_same(each, new)), None)
        if old is None:
            continue
        left.remove(old)
        if old["mark"] != new["mark"]:
            reasons = [texts.say(f"why.{part}") for part in _reasons(old["parts"], new["parts"])]
            why = ", ".join(reasons) or texts.say("why.chance")
            rows.append(
                [inert(new["name"]), number(old["mark"], texts), number(new["mark"], texts), why]
            )
    for old in left:
        if old["mark"] is not None:
            gone = texts.say("why.gone")
            rows.append([inert(old["name"]), number(old["mark"], texts), "", gone])
    return rows


def _reasons(old: Mapping[str, str], new: Mapping[str, str]) -> Iterator[str]:
    """Yield what a mark depends on and has changed; where there was no result, nothing of it."""
    for part in sorted({*old, *new}):
        both = part in old and part in new
        if old.get(part) != new.get(part) and (both or part not in _RESULT):
            yield part


def changes_table(rows: Sequence[Sequence[str]], texts: Texts) -> bytes:
    """Return changes.csv."""
    header = [texts.say(f"heading.{name}") for name in ("name", "before", "mark", "why")]
    return table(header, rows, texts)


def read(out: Path) -> dict[str, Any]:
    """Return what the last run has left; nothing when there was none, or it cannot be read."""
    empty: dict[str, Any] = {name: kind() for name, kind in _TABLES.items()}
    try:
        content: dict[str, Any] = json.loads((out / MARKS).read_text(encoding="utf-8"))
        whole = all(isinstance(content[name], kind) for name, kind in _TABLES.items())
        known = all(
            isinstance(each["parts"], dict) and {"mark", "name", "number", "moodle"} <= {*each}
            for each in content["people"]
        )
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return empty
    return content if whole and known else empty
