"""The known mistakes: reference/mistakes/ID.patch each, listed in mistakes.toml.

Adding one takes a patch, an entry there, and its texts in grader/course/messages/*/mistakes.toml.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from grader.authoring.skeleton.skeleton import find_regions
from grader.authoring.specimens import patches
from grader.authoring.specimens.shares import Range, span
from grader.course import exercises
from grader.course.exercises import EXPECTED, ManifestError, read_toml
from grader.evaluation import recognition
from grader.intake.originals import REFERENCE
from grader.intake.records import Submission

FOLDER = REFERENCE / "mistakes"


@dataclass(frozen=True)
class Mistake:
    """A plausible mistake in one exercise, as a patch on the reference."""

    id: str
    exercise: str
    worth: Range  # the share of its points that a teacher takes off, pictures aside
    seen_from: str  # the exercise before which nothing can show it: mostly its own
    twins: tuple[str, ...] = ()  # mistakes that no stored answer tells from this one
    folder: Path = FOLDER

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
        """What stands for it: what its patch changes, wherever that stands, and the solution."""
        patch = (self.folder / f"{self.id}.patch").read_text(encoding="utf-8")
        return re.sub(r"^@@.*", "@@", patch, flags=re.MULTILINE) + solutions()[self.exercise]

    def files(self) -> dict[str, str]:
        """Return the reference's files with the mistake in them. Raises PatchError."""
        return patches.patched(self.folder / f"{self.id}.patch", patches.reference())

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
    """Read the list of a folder. Raises ManifestError."""
    path = folder / "mistakes.toml"
    data = read_toml(path)
    try:
        worth = {name: span(values) for name, values in data["worth"].items()}
        return tuple(
            Mistake(
                id=name,
                exercise=row["exercise"],
                worth=worth[row["worth"]],
                twins=tuple(row.get("twins", ())),
                seen_from=row.get("seen_from", row["exercise"]),
                folder=folder,
            )
            for name, row in data["mistake"].items()
        )
    except (KeyError, TypeError, ValueError) as error:
        raise ManifestError(f"{path.name}: missing or malformed key: {error}") from error
