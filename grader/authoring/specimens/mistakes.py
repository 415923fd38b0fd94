"""The known mistakes, each a change of the reference: reference/mistakes/ has them by exercise."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from grader.authoring.skeleton.skeleton import find_regions
from grader.authoring.specimens import patches
from grader.authoring.specimens.edits import FunctionEdit
from grader.authoring.specimens.shares import Range, span
from grader.authoring.specimens.wrong import FOLDER, WORTH, tables
from grader.course import exercises
from grader.course.exercises import EXPECTED, malformed, read_toml
from grader.evaluation import recognition
from grader.intake.originals import REFERENCE
from grader.intake.records import Submission


@dataclass(frozen=True)
class Mistake:
    """A plausible mistake in one exercise: a change of one function, or a patch ID.patch."""

    id: str
    exercise: str
    worth: Range  # the share of its points that a teacher takes off, pictures aside
    seen_from: str  # the exercise before which nothing can show it: mostly its own
    twins: tuple[str, ...] = ()  # mistakes that no stored answer tells from this one
    folder: Path = FOLDER
    edit: FunctionEdit | None = None  # None: it is a patch

    @property
    def tp(self) -> int:
        """The TP of its exercise."""
        return exercises.load().exercise(self.exercise).tp

    @property
    def shows(self) -> tuple[str, ...]:
        """The checks of its exercise that see it, pictures apart: those that the bank has."""
        known = recognition.read(EXPECTED).get(self.id)
        checks = exercises.load().exercise(self.exercise).checks
        return tuple(each.id for each in checks if known and each.id in known.signature)

    @property
    def written(self) -> str:
        """What stands for it: what it changes, wherever that stands, and the solution."""
        if self.edit:
            return f"{self.edit}{solutions()[self.exercise]}"
        patch = (self.folder / f"{self.id}.patch").read_text(encoding="utf-8")
        return re.sub(r"^@@.*", "@@", patch, flags=re.MULTILINE) + solutions()[self.exercise]

    def files(self, onto: Mapping[str, str] | None = None) -> dict[str, str]:
        """Return files, the reference's unless others are given, with the mistake in them.

        Raises PatchError.
        """
        if self.edit:
            return self.edit.files(onto)
        files = patches.reference() if onto is None else onto
        return patches.patched(self.folder / f"{self.id}.patch", files)

    def submission(self) -> Submission:
        """Return it as a submission. Raises PatchError."""
        return patches.submission(self.id, self.files())


@cache
def solutions() -> dict[str, str]:
    """Return what the reference has between the marks of each exercise."""
    found = {each.id: "" for each in exercises.load().exercises}
    for name, text in patches.reference().items():
        lines = text.split("\n")
        for region in find_regions(REFERENCE / name, lines, found):
            found[region.exercise] += "\n".join(lines[region.begin : region.end])
    return found


@cache
def load(folder: Path = FOLDER) -> tuple[Mistake, ...]:
    """Read the mistakes of a folder, in the course's order. Raises ManifestError."""
    shares = folder / WORTH
    found: list[Mistake] = []
    try:
        worth = {name: span(values) for name, values in read_toml(shares)["worth"].items()}
    except (KeyError, TypeError, ValueError) as error:
        raise malformed(shares, error) from error
    for exercise, path, data in tables(folder):
        try:
            own = data.get("mistake", {}).items()
            found += [_mistake(name, exercise, row, worth, folder) for name, row in own]
        except (KeyError, TypeError, AttributeError) as error:
            raise malformed(path, error) from error
    return tuple(found)


def _mistake(
    name: str, exercise: str, row: Mapping[str, Any], worth: Mapping[str, Range], folder: Path
) -> Mistake:
    words = [row[each] for each in ("function", "before", "after") if each in row]
    return Mistake(
        id=name,
        exercise=exercise,
        worth=worth[row["worth"]],
        twins=tuple(row.get("twins", ())),
        seen_from=row.get("seen_from", exercise),
        folder=folder,
        edit=FunctionEdit(name, exercise, *words) if words else None,
    )
