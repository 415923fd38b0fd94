"""Comparing pictures up to a pixel: rounding moves edges a little, but brings no new colour.

With scikit-image: ask `image_tools.are_there` first.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from grader.checking.shapes import Mask

Planes = npt.NDArray[Any]


@dataclass(frozen=True)
class Surroundings:
    """The least and the greatest of the colours around each pixel, shape (height, width, 3)."""

    low: Planes
    high: Planes

    @classmethod
    def of(cls, image: Planes, radius: int = 1) -> Surroundings:
        """Return what is around each pixel, in the square of `radius` pixels to each side."""
        from skimage.morphology import dilation, erosion

        square = np.ones((2 * radius + 1, 2 * radius + 1, 1))
        return cls(erosion(image, square), dilation(image, square))

    def excluding(self, picture: Planes, slack: float | Planes) -> Mask:
        """Return where the colours of another picture do not lie between those around.

        Parameters
        ----------
        picture
            shape (height, width, 3), in the units of `slack`
        slack
            by how much a colour may exceed those around; a number, or of shape (height, width, 1)

        Returns
        -------
            shape (height, width)
        """
        found = ((picture < self.low - slack) | (picture > self.high + slack)).any(axis=2)
        return np.asarray(found)
