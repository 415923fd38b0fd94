"""Programs as people write them: reference/cases/ID.patch each, and the marks that they deserve.

They come from outside: from public reports of people who write ray tracers, and from habits seen in
programs of this course. The head of `cases.toml` says what it says of each.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from grader.authoring.specimens import patches
from grader.authoring.specimens.shares import Range, span
from grader.course.exercises import malformed, read_toml
from grader.intake.originals import REFERENCE
from grader.intake.records import Submission

FOLDER = REFERENCE / "cases"


@dataclass(frozen=True)
class Case:
    """A program from outside, as a patch on the reference."""

    id: str
    about: str
    loses: Mapping[str, Range] = field(default_factory=dict)  # shares, by exercise: least and most
    named: tuple[str, ...] = ()  # known mistakes; none: it is named as none
    earns: float | None = None  # of what is no work: points at most, whatever it loses
    unmet: str = ""  # what the grader does instead, where it does not do that yet

    def files(self) -> dict[str, str]:
        """Return its files. Raises PatchError."""
        return patches.patched(FOLDER / f"{self.id}.patch", patches.reference())

    def submission(self) -> Submission:
        """Return it as a submission. Raises PatchError."""
        return patches.submission(self.id, self.files())


@cache
def load(path: Path = FOLDER / "cases.toml") -> tuple[Case, ...]:
    """Read the list. Raises ManifestError."""
    try:
        return tuple(
            Case(
                id=name,
                about=row["about"],
                loses={exercise: span(each) for exercise, each in row.get("loses", {}).items()},
                named=tuple(row.get("named", ())),
                earns=row.get("earns"),
                unmet=row.get("unmet", ""),
            )
            for name, row in read_toml(path)["case"].items()
        )
    except (KeyError, TypeError, ValueError) as error:
        raise malformed(path, error) from error
