"""A wrong value, and what the values of a pixel are held against."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from grader import manifest
from grader.lab.inspector.maps import Wanted
from grader.lab.inspector.nodes import Node
from grader.lab.inspector.probe import Probe
from grader.lab.vectors import Array
from grader.pictures.stored import BRIGHTEST

_FUNCTIONS = {"TP4.B1": "octree_intersect", "TP5.B1": "glass_color"}
CLOSE = 2e-3  # of directions and colours
FAR_T = 1e-3  # of distances, in their own share


@dataclass(frozen=True)
class Fault:
    """A value that is wrong: its key, where it stands, and the exercise that makes it."""

    value: str  # of [lab.inspect.value] in messages/
    exercise: str
    depth: int = 0  # of the ray: 0 the camera's, 1 its first bounce ...
    light: int | None = None
    wanted: str = ""  # the reference's value, for who asks

    @property
    def function(self) -> str:
        """Return the function to look at."""
        first = manifest.load().exercise(self.exercise).functions[0]
        return _FUNCTIONS.get(self.exercise, first)


@dataclass(frozen=True)
class Case:
    """A replayed pixel, and what it is held against."""

    probe: Probe
    pixel: tuple[int, int]
    root: Node
    wanted: Wanted | None
    drawn: Array | None  # the colour in the picture; None when there is no picture


def far(got: Any, wanted: Any, near: float = CLOSE) -> bool:
    """Return whether values differ, NaN included; `near` is absolute, and a share above 1."""
    got, wanted = np.asarray(got, np.float64), np.asarray(wanted, np.float64)
    return not bool((np.abs(got - wanted) <= near * np.maximum(1, np.abs(wanted))).all())


def outside(got: Array, low: Array, high: Array) -> bool:
    """Return whether colours lie outside all of the accepted ranges, shape (count, 3)."""
    got = np.minimum(np.asarray(got, np.float64), BRIGHTEST)
    slack = CLOSE + 0.01 * np.abs(high)
    return not bool(((got >= low - slack) & (got <= high + slack)).all(axis=1).any())


def told(value: Any) -> str:
    """Return a value as it is shown to who asks."""
    return np.array2string(np.asarray(value, np.float32), precision=4, separator=", ")
