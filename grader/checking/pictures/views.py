"""What a report shows of a wrong picture: PNG files, the top row first."""

from __future__ import annotations

import io
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
from PIL import Image as Pillow

from grader.checking.pictures.measure import TILE, Floats
from grader.checking.shapes import Image

Bytes = npt.NDArray[np.uint8]

# Differences: blue is too dark, white is right, orange is too bright, with stripes that show in
# grey; the two ends and the scale never change, and can be told apart by colour-blind eyes.
DARK = np.array([0.0, 0.28, 0.62], np.float32)
BRIGHT = np.array([0.78, 0.36, 0.0], np.float32)
FULL = 0.25  # the difference that has the whole colour
ROOT = 0.5  # small differences show too
STRIPES, FAINT = 5, 0.4  # one diagonal in so many is so faint, where it is too bright
FRAME = (20, 20, 20)
ZOOM = 8
AROUND = 4  # pixels shown around the worst tile
GAP = 8  # between the two sides of the detail, pixels


def images(
    got: Image, expected: Image, outside: Floats, worst: tuple[int, int]
) -> Mapping[str, bytes]:
    """Return expected, got, their difference, and a detail: the worst tile, enlarged.

    The detail has the expected tile on its left and the one got on its right. `got` may hold
    anything; `outside` (height, width) is how far each pixel is from what is accepted.
    """
    shown = np.clip(np.nan_to_num(got, nan=0.0, posinf=1.0, neginf=0.0), 0, 1)
    return {
        "expected": _png(_bytes(expected)),
        "got": _png(_bytes(shown)),
        "difference": _png(_framed(difference(shown, expected, outside), worst)),
        "detail": _png(_detail(shown, expected, worst)),
    }


def difference(got: Image, expected: Image, outside: Floats) -> Bytes:
    """Return how far the picture is from what is accepted, as colours."""
    strength = np.clip(outside / FULL, 0, 1) ** ROOT
    over = (got - expected).sum(axis=2) > 0
    diagonal = np.add.outer(*(np.arange(size) for size in over.shape)) % STRIPES == 0
    strength = np.where(over & diagonal, FAINT * strength, strength)
    ends = np.where(over[:, :, None], BRIGHT, DARK)
    return _bytes(1 + strength[:, :, None] * (ends - 1))


def tile_around(row: int, column: int, shape: tuple[int, ...]) -> tuple[int, int]:
    """Return the first row and column of a tile that has a pixel in its middle, if it can."""
    first = (each - TILE // 2 for each in (row, column))
    pairs = zip(first, shape, strict=True)
    bottom, left = (min(max(each, 0), size - TILE) for each, size in pairs)
    return bottom, left


def _framed(pixels: Bytes, worst: tuple[int, int]) -> Bytes:
    """Draw a frame around a tile."""
    bottom, left = (max(each - 1, 0) for each in worst)
    top = min(bottom + TILE + 1, pixels.shape[0] - 1)
    right = min(left + TILE + 1, pixels.shape[1] - 1)
    pixels = pixels.copy()
    pixels[[bottom, top], left : right + 1] = FRAME
    pixels[bottom : top + 1, [left, right]] = FRAME
    return pixels


def _detail(got: Image, expected: Image, worst: tuple[int, int]) -> Bytes:
    size = TILE + 2 * AROUND
    row = min(max(worst[0] - AROUND, 0), got.shape[0] - size)
    column = min(max(worst[1] - AROUND, 0), got.shape[1] - size)
    sides = []
    for each in (expected, got):
        part = _bytes(each[row : row + size, column : column + size])
        sides.append(part.repeat(ZOOM, axis=0).repeat(ZOOM, axis=1))
    gap = np.full((size * ZOOM, GAP, 3), 255, np.uint8)
    return np.concatenate([sides[0], gap, sides[1]], axis=1)


def _bytes(picture: Image) -> Bytes:
    levels: Bytes = np.rint(picture * 255).astype(np.uint8)
    return levels


def _png(pixels: Bytes) -> bytes:
    memory = io.BytesIO()
    Pillow.fromarray(np.ascontiguousarray(pixels[::-1])).save(memory, "PNG")
    return memory.getvalue()
