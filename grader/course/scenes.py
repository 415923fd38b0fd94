"""The scenes whose pictures are expected: scenes.toml, read once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from grader.course.exercises import PACKAGE, malformed, read_toml

TABLE = PACKAGE / "course" / "scenes.toml"


@dataclass(frozen=True)
class SceneRules:
    """A scene of core_c/scene.c, as scenes.toml says it."""

    stages: tuple[str, ...]
    things: tuple[str, ...]  # its objects in order; one name stands for all
    transparent: tuple[str, ...] = ()
    octree: bool = False
    patterned: bool = False
    shows: tuple[str, ...] = ()  # bonuses that one sees in it

    def thing(self, index: int) -> str:
        """Return what an object is called."""
        return self.things[index] if len(self.things) > 1 else self.things[0]


@cache
def load(path: Path = TABLE) -> Mapping[int, SceneRules]:
    """Read the scenes by their numbers. Raises ManifestError."""
    data = read_toml(path)
    try:
        groups = data["stages"]
        return {int(number): _scene(row, groups) for number, row in data["scene"].items()}
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise malformed(path, error) from error


def _scene(row: Mapping[str, Any], groups: Mapping[str, list[str]]) -> SceneRules:
    rules: dict[str, Any] = {}
    for name, each in row.items():
        rules[name] = tuple(each) if isinstance(each, list) else each
    rules["stages"] = tuple(one for each in row["stages"] for one in groups.get(each, [each]))
    if not rules["things"]:
        raise ValueError("things")
    return SceneRules(**rules)
