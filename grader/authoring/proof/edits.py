"""Judging changes of one function by the checks of the exercise that must lose points."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from pathlib import Path

from grader.authoring.proof.mutants_changes import Mutant
from grader.authoring.proof.mutants_family import Kit, opened
from grader.authoring.proof.mutants_judging import fails
from grader.authoring.specimens.edits import FunctionEdit
from grader.course import exercises

FAMILY = 30  # changes of a function that are compiled together, at most


def caught(chosen: Sequence[FunctionEdit], cache: Path) -> Iterator[tuple[str, str]]:
    """Yield the id of each change, and the check of its exercise that fails; "" when none.

    `cache` is a folder of builds that nothing else uses.
    """
    rows = sorted(((mutant(each), each) for each in chosen), key=lambda row: row[0].function)
    for _, family in groupby(rows, key=lambda row: row[0].function):
        listed = list(family)
        for k in range(0, len(listed), FAMILY):
            yield from _of_family(dict(listed[k : k + FAMILY]), cache)


def _of_family(rows: Mapping[Mutant, FunctionEdit], cache: Path) -> Iterator[tuple[str, str]]:
    with opened([*rows], cache) as (kit, built):
        for number, each in enumerate(built, 1):
            kit.choose(number)
            yield rows[each].id, _failing(kit, rows[each].exercise)
        for each in rows.keys() - {*built}:
            yield rows[each].id, ""


def _failing(kit: Kit, exercise: str) -> str:
    """Return the first check of an exercise that costs points, pictures aside."""
    own = exercises.load().exercise(exercise).checks
    return next((each.id for each in own if not each.is_picture and fails(kit, each)), "")


def mutant(edit: FunctionEdit) -> Mutant:
    """Return a change as a mutant of its function. Raises PatchError."""
    file, written = edit.written()
    return Mutant(file, edit.function, 0, "edit", edit.before, edit.after, written)
