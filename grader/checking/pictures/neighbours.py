"""Comparing pictures up to a pixel: rounding moves edges a little, but brings no new colour."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from grader.checking.shapes import Mask

Planes = npt.NDArray[Any]


def beyond(picture: Planes, other: Planes, slack: float | Planes, radius: int = 1) -> Mask:
    """Return where a picture's colours do not lie between those around the same pixel of another.

    Parameters
    ----------
    picture, other
        shape (height, width, 3), both in the units of `slack`
    slack
        by how much a colour may exceed those around; a number, or of shape (height, width, 1)
    radius
        of what is around, in pixels

    Returns
    -------
        shape (height, width)
    """
    low = _spread(other, np.minimum, radius)
    high = _spread(other, np.maximum, radius)
    found = ((picture < low - slack) | (picture > high + slack)).any(axis=2)
    return np.asarray(found)


def _spread(image: Planes, choose: Callable[..., Any], radius: int) -> Planes:
    """Return the least or the greatest of the pixels around each."""
    for axis in (0, 1):
        size = image.shape[axis]
        pad = [(radius, radius) if each == axis else (0, 0) for each in range(3)]
        wide = np.pad(image, pad, mode="edge")
        image = wide.take(range(size), axis=axis)
        for step in range(1, 2 * radius + 1):
            choose(image, wide.take(range(step, step + size), axis=axis), out=image)
    return image
