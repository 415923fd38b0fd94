"""Slips: mistakes that a student may well make and that no change of one token makes.

reference/slips.toml lists them: its head says how.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

from grader.authoring.specimens.edits import FunctionEdit
from grader.course.exercises import malformed, read_toml
from grader.intake.originals import REFERENCE

TABLE = REFERENCE / "slips.toml"


@dataclass(frozen=True)
class Slip(FunctionEdit):
    """The reference with a mistake in one function; `thought` is what led to it."""

    thought: str

    @property
    def listed_in(self) -> str:
        """The file that errors name."""
        return TABLE.name


@cache
def load(path: Path = TABLE) -> tuple[Slip, ...]:
    """Read the table. Raises ManifestError."""
    try:
        return tuple(
            Slip(id=name, exercise=exercise, **row)
            for exercise, rows in read_toml(path).items()
            for name, row in rows.items()
        )
    except (TypeError, AttributeError) as error:
        raise malformed(path, error) from error
