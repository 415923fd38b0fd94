"""What may be wrong in each exercise, reference/mistakes/EXERCISE.toml: worth.toml tells how."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from grader.course import exercises
from grader.course.exercises import ManifestError, read_toml
from grader.intake.originals import REFERENCE

FOLDER = REFERENCE / "mistakes"
WORTH = "worth.toml"


def tables(folder: Path) -> Iterator[tuple[str, Path, dict[str, Any]]]:
    """Yield what a folder has of each exercise, in the course's order. Raises ManifestError."""
    ids = [each.id for each in exercises.load().exercises]
    found = {path.stem: path for path in folder.glob("TP*.toml")}
    if unknown := sorted(set(found) - {*ids}):
        raise ManifestError(f"{unknown[0]}.toml: exercises.toml has no such exercise")
    for name in ids:
        if name in found:
            yield name, found[name], read_toml(found[name])
