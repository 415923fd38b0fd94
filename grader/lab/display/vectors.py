"""Points, vectors and colours: numpy arrays of three numbers, which add up as in the formulas."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from grader.lab.display.card import Shown, escape

Array = npt.NDArray[Any]


def number(value: float) -> str:
    """Return a number as short as it can be told."""
    return f"{value + 0.0:.4g}"  # no -0


def numbers(array: Array) -> str:
    """Return three numbers as C's tuples are told; another array as numpy shows it."""
    if array.shape == ():
        return str(array.item())
    if array.shape != (3,):
        return repr(np.asarray(array))
    return f"({', '.join(number(float(each)) for each in np.asarray(array))})"


class Vec3(np.ndarray[Any, Any]):
    """Three numbers x, y, z: a point or a vector, in scene units. Read-only."""

    def __new__(cls, values: npt.ArrayLike) -> Vec3:
        """Copy three numbers."""
        array = np.array(values, np.float32).reshape(3).view(cls)
        array.flags.writeable = False
        return array

    @property
    def x(self) -> float:
        """The first number."""
        return float(self[0])

    @property
    def y(self) -> float:
        """The second number."""
        return float(self[1])

    @property
    def z(self) -> float:
        """The third number."""
        return float(self[2])

    def __repr__(self) -> str:
        return numbers(self)

    __str__ = __repr__


class Color(Vec3):
    """Three numbers r, g, b, each in [0, 1] but for lights. Read-only."""

    @property
    def r(self) -> float:
        """Red."""
        return float(self[0])

    @property
    def g(self) -> float:
        """Green."""
        return float(self[1])

    @property
    def b(self) -> float:
        """Blue."""
        return float(self[2])

    def _repr_html_(self) -> str | None:
        """Return the numbers beside a patch of the colour."""
        return swatch(self).html if self.shape == (3,) else None


def swatch(color: Color) -> Shown:
    """Return a colour as its numbers, beside a patch of it."""
    levels = np.nan_to_num(np.clip(np.asarray(color), 0, 1) * 255).astype(int)
    style = (
        "display:inline-block;width:1em;height:1em;border:1px solid #888;"
        "vertical-align:middle;margin-right:.4em;"
        f"background:rgb({levels[0]},{levels[1]},{levels[2]})"
    )
    return Shown(f'<span style="{style}"></span>{escape(repr(color))}', repr(color))
