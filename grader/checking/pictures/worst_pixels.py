"""Where a picture is most wrong: the pixels to look at."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from grader.checking.pictures import expected_files
from grader.checking.pictures.measure import TILE, Envelope, Floats, outside, worst_tile
from grader.checking.pictures.plan import ExpectedPicture
from grader.checking.shapes import Image, Mask

Pixel = tuple[int, int]  # column, row

MOST = 5
APART = 4  # pixels that lie nearer to one another tell the same
_TIE = 1e-6  # what a pixel counts less for each step from the middle of its tile


def worst_pixel(folder: Path, picture: ExpectedPicture, got: Image) -> Pixel | None:
    """Return the pixel of a picture to look at first; None when nothing is outside.

    `folder` is that of the expected data, `got` has shape (180, 320, 3), row 0 at the bottom.
    Raises ExpectedError.
    """
    envelope = expected_files.read(folder, picture).envelope
    error = outside(np.nan_to_num(np.asarray(got, np.float32)), envelope)
    return next(iter(worst_pixels(error, envelope)), None)


def worth_a_look(error: Floats, envelope: Envelope) -> Mask:
    """Return the wrong pixels that tell most: those of edges only where nothing else is wrong.

    Where samples matter, edges tell as much. `error` is what `outside` gives.
    """
    wrong: Mask = error > envelope.far
    calm = wrong if envelope.band else wrong & envelope.calm
    return calm if calm.any() else wrong


def worst_pixels(error: Floats, envelope: Envelope) -> tuple[Pixel, ...]:
    """Return pixels of the worst tile, those farthest from what is accepted first.

    `error` is what `outside` gives.
    """
    counted = np.where(worth_a_look(error, envelope), error, 0)
    if not counted.any():
        return ()
    _, (row, column) = worst_tile(np.rint(counted * 255).astype(np.int32))
    tile = counted[row : row + TILE, column : column + TILE].copy()
    y, x = np.indices(tile.shape)
    tile[tile > 0] -= _TIE * np.maximum(np.abs(y - TILE / 2), np.abs(x - TILE / 2))[tile > 0]
    found: list[Pixel] = []
    while len(found) < MOST and tile.max() > 0:
        j, i = divmod(int(tile.argmax()), tile.shape[1])
        found.append((column + i, row + j))
        tile[max(j - APART, 0) : j + APART + 1, max(i - APART, 0) : i + APART + 1] = 0
    return tuple(found)
