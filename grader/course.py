"""The settings of the course, course.toml, read once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

from grader.manifest import PACKAGE, ManifestError, read_toml
from grader.manifest import load as load_manifest

COURSE = PACKAGE / "course.toml"
LANGUAGES = ("fr", "en")
DIALECTS = ("c", "c++")


@dataclass(frozen=True)
class Course:
    """What an instructor may change."""

    language: str
    dialect: str
    opened: tuple[int, ...]


@cache
def load(path: Path = COURSE) -> Course:
    """Read the settings. Raises ManifestError, naming the file and what is wrong."""
    data = read_toml(path)
    known = {"language": LANGUAGES, "dialect": DIALECTS}
    for key, values in known.items():
        if data.get(key) not in values:
            raise ManifestError(f"{path.name}: {key} must be one of {', '.join(values)}")
    tps = load_manifest().tps
    opened = data.get("opened")
    if not isinstance(opened, list) or not set(map(str, opened)) <= set(map(str, tps)):
        raise ManifestError(f"{path.name}: opened must be a list of TPs such as [1, 2]")
    unknown = set(data) - {*known, "opened"}
    if unknown:
        raise ManifestError(f"{path.name}: unknown: {', '.join(sorted(unknown))}")
    return Course(data["language"], data["dialect"], tuple(sorted(opened)))
