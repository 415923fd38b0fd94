"""Where a picture is most wrong: the pixel to look at first."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from grader.pictures import stored
from grader.pictures.measure import TILE, Envelope, outside, worst_tile
from grader.pictures.plan import Picture
from grader.shapes import Image

Pixel = tuple[int, int]


def worst_pixel(folder: Path, picture: Picture, got: Image) -> Pixel | None:
    """Return column and row of the pixel farthest from what is accepted, in the worst tile.

    `folder` is that of the expected data, `got` has shape (180, 320, 3), row 0 at the bottom.
    Where the neighbours' rays take the same path comes first. None when nothing is outside.
    Raises ExpectedError.
    """
    envelope = stored.read(folder, picture).envelope
    return farthest(np.nan_to_num(np.asarray(got, np.float32)), envelope)


def farthest(got: Image, envelope: Envelope) -> Pixel | None:
    """Return the pixel of a finite picture that is farthest outside; see `worst_pixel`."""
    error = outside(got, envelope)
    wrong = error > envelope.far
    if not wrong.any():
        return None
    calm = wrong & envelope.calm
    error[~(calm if calm.any() else wrong)] = 0
    _, (row, column) = worst_tile(np.rint(error * 255).astype(np.int32))
    tile = error[row : row + TILE, column : column + TILE]
    j, i = divmod(int(tile.argmax()), tile.shape[1])
    return column + i, row + j
