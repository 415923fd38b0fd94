"""A wrong value, and what the values of a pixel are held against."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from grader.checking.expected_data import Array
from grader.checking.pictures import expected_files
from grader.checking.pictures.expected_files import BRIGHTEST
from grader.course import exercises
from grader.course.message import Message
from grader.evaluation.replay.expected_maps import Wanted
from grader.evaluation.replay.probe import Probe
from grader.evaluation.replay.ray_tree import Node
from grader.intake.header_numbers import kinds

_FUNCTIONS = {"TP4.B1": "octree_intersect"}
CLOSE = 2e-3  # of directions and colours
_ROUNDING = 1.2e-7  # of a coordinate
FAR_T = 1e-3  # of distances, in their own share
# The exercise that meets each type of object.
SHAPES = {"SPHERE": "TP2.4", "PLANE": "TP2.3", "CYLINDER": "TP2.B1", "CONE": "TP2.B2"}


@dataclass(frozen=True)
class WrongValue:
    """A value that is wrong: its key, where it stands, and the exercise that makes it."""

    value: str  # of [replay.value] in messages/
    exercise: str
    depth: int = 0  # of the ray: 0 the camera's, 1 its first bounce ...
    light: int | None = None
    wanted: str = ""  # the reference's value, for who asks
    named: str = ""  # the function to look at, when it is not the exercise's first

    @property
    def function(self) -> str:
        """Return the function to look at."""
        first = exercises.load().exercise(self.exercise).functions[0]
        return self.named or _FUNCTIONS.get(self.exercise, first)

    @property
    def message(self) -> Message:
        """Which value goes wrong first, and where it is made, as a sentence."""
        place = "light" if self.light is not None else "bounce" if self.depth else "eye"
        where = Message(f"replay.of.{place}", {"light": self.light, "depth": self.depth})
        values: dict[str, object] = {
            "value": Message(f"replay.value.{self.value}"),
            "where": where,
            "exercise": self.exercise,
            "function": self.function,
        }
        return Message("replay.first", values)


@dataclass(frozen=True)
class ReplayedPixel:
    """A replayed pixel, and what it is held against."""

    probe: Probe
    pixel: tuple[int, int]
    root: Node
    wanted: Wanted | None
    drawn: Array | None  # the colour in the picture; None when there is no picture
    folder: Path  # of the expected data

    @cached_property
    def texels(self) -> Array:
        """The texture that the maps were made with. Raises ExpectedError."""
        return expected_files.read_texels(self.folder)

    def tells_start(self, point: Array) -> bool:
        """Return whether rounding leaves the epsilon by which a ray from a point is moved."""
        epsilon = float(self.probe.content.options["epsilon"])
        return float(np.abs(point).max()) * _ROUNDING <= epsilon / 20

    def shape(self, index: int) -> str:
        """Return the exercise that meets an object."""
        return SHAPES[kinds()[int(self.probe.content.objects["type"][index])]]


def far(got: Any, wanted: Any, near: float = CLOSE) -> bool:
    """Return whether values differ, NaN included; `near` is absolute, and a share above 1."""
    got, wanted = np.asarray(got, np.float64), np.asarray(wanted, np.float64)
    with np.errstate(invalid="ignore"):
        return not bool((np.abs(got - wanted) <= near * np.maximum(1, np.abs(wanted))).all())


def unlike(got: Array, parts: Array) -> bool:
    """Return whether a colour is not the sum of its parts; where these are no numbers, it is."""
    known = np.isfinite(parts)
    return far(np.asarray(got)[known], np.asarray(parts)[known])


def outside(got: Array, low: Array, high: Array) -> bool:
    """Return whether colours lie outside all of the accepted ranges, shape (count, 3)."""
    got = np.minimum(np.asarray(got, np.float64), BRIGHTEST)
    slack = CLOSE + 0.01 * np.abs(high)
    return not bool(((got >= low - slack) & (got <= high + slack)).all(axis=1).any())


def told(value: Any) -> str:
    """Return a value as it is shown to who asks."""
    return np.array2string(np.asarray(value, np.float32), precision=4, separator=", ")
