"""grades.csv, one line for each person."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from grader.batch.csv_table import Sheet, inert, written
from grader.batch.records import Graded, Mark
from grader.course import exercises as manifest
from grader.course.texts import Texts

GRADES = "grades.csv"
Cell = str | float | None
_FIELDS = ("name", "number", "participant", "submission", "pseudonym", "mark", "points", "bonus")
_AFTER = ("rubric", "days_late", "penalty", "comment", "remarks")


def grades(
    marks: Sequence[Mark], graded: Mapping[str, Graded], hidden: Mapping[str, str], texts: Texts
) -> bytes:
    """Return grades.csv: what spreadsheets of the language open by a double click.

    `hidden` are the pseudonyms of the submissions.
    """
    header, rows = cells(marks, graded, hidden, texts)
    written = [
        [inert(each) if isinstance(each, str) else number(each, texts) for each in row]
        for row in rows
    ]
    return table(header, written, texts)


def cells(
    marks: Sequence[Mark], graded: Mapping[str, Graded], hidden: Mapping[str, str], texts: Texts
) -> tuple[list[str], list[list[Cell]]]:
    """Return the headings, and for each person a row of texts and numbers."""
    exercises = [each.id for each in manifest.load().exercises]
    header = [texts.say(f"heading.{name}") for name in _FIELDS] + exercises
    header += [texts.say(f"heading.{name}") for name in _AFTER]
    rows = [_row(each, graded, exercises, hidden, texts) for each in marks]
    return header, rows


def _row(
    mark: Mark,
    graded: Mapping[str, Graded],
    exercises: Sequence[str],
    hidden: Mapping[str, str],
    texts: Texts,
) -> list[Cell]:
    member = mark.member
    known = graded.get(member.submission)
    results = known.results if known and known.results else {"exercises": {}}
    counted = mark.value is not None and bool(results["exercises"])
    numbers = (mark.points, mark.bonus) if counted else (None, None)
    after = (mark.rubric, mark.late_days, mark.penalty) if counted else (None, None, None)
    shown = {} if member.unsettled else results["exercises"]
    earned = [shown.get(name) for name in exercises]
    return [
        *(member.name, member.number, member.moodle, member.submission),
        hidden.get(member.submission, ""),
        *(_rounded(each) for each in (mark.value, *numbers)),
        *(_rounded(each[1] if each else None) for each in earned),
        *(_rounded(each) for each in after),
        mark.comment,
        " ".join(sentence(mark, texts)),
    ]


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 3)


def sentence(mark: Mark, texts: Texts, leave: Collection[str] = ()) -> list[str]:
    """Return what is to be known of a mark, but for some kinds of sentences."""
    told = [each for each in mark.why if each.key not in leave]
    return list(dict.fromkeys(texts.say(each.key, **each.values) for each in told))


def number(value: float | None, texts: Texts) -> str:
    """Return a mark as a cell; none is an empty one."""
    return "" if value is None else texts.number(round(value, 3))


def table(header: Sequence[str], rows: Sequence[Sequence[str]], texts: Texts) -> bytes:
    """Return a table as spreadsheets of the language open it."""
    # Where a comma is the decimal sign it parts no cells; the mark of UTF-8 is for Excel.
    delimiter = ";" if texts.say("language.decimal") == "," else ","
    lines = tuple(range(2, len(rows) + 2))
    cells = tuple(tuple(row) for row in rows)
    return written(Sheet(tuple(header), cells, lines, delimiter, bom=True, newline="\r\n"))
