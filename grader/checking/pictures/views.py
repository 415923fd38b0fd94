"""What a report shows of a wrong picture: PNG files, the top row first."""

from __future__ import annotations

import io
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from PIL import Image as Pillow
from PIL import ImageDraw, ImageFont

from grader.checking.pictures import image_tools
from grader.checking.pictures.measure import TILE, Floats
from grader.checking.shapes import Image

Box = tuple[int, int, int, int]  # first row and column, and those after the last
Bytes = npt.NDArray[np.uint8]

# Differences: blue is too dark, white is right, orange is too bright, with stripes that show in
# grey; the two ends and the scale never change, and can be told apart by colour-blind eyes.
DARK = np.array([0.0, 0.28, 0.62], np.float32)
BRIGHT = np.array([0.78, 0.36, 0.0], np.float32)
FULL = 0.25  # the difference that has the whole colour
ROOT = 0.5  # small differences show too
STRIPES, FAINT = 5, 0.4  # one diagonal in so many is so faint, where it is too bright
FRAME = (20, 20, 20)
BOX, PAPER = (105, 105, 105), (255, 255, 255)  # of a place's box and its number, and behind it
BESIDE = 2  # pixels between a place and its box
DIGIT = (8, 10)  # width and height of a number, pixels
SHADES = 16  # of the map of what is alike
ZOOM = 8
AROUND = 4  # pixels shown around the worst tile
GAP = 8  # between the two sides of the detail, pixels


def images(
    got: Image,
    expected: Image,
    outside: Floats,
    worst: tuple[int, int],
    boxes: Sequence[Box] = (),
) -> dict[str, bytes]:
    """Return expected, got, their difference, and a detail: the worst tile, enlarged.

    The detail has the expected tile on its left and the one got on its right. `got` may hold
    anything; `outside` (height, width) is how far each pixel is from what is accepted. `boxes` are
    drawn in the difference with their numbers.
    """
    shown = _shown(got)
    return {
        "expected": _png(_bytes(expected)),
        "got": _png(_bytes(shown)),
        "difference": _marked(difference(shown, expected, outside), worst, boxes),
        "detail": _png(_detail(shown, expected, worst)),
    }


def alike(got: Image, expected: Image) -> dict[str, bytes]:
    """Return the map of how alike two pictures are around each pixel, white where they are.

    Nothing without scikit-image.
    """
    found = image_tools.similarity(_shown(got), expected)
    if found is None:
        return {}
    # Few levels: what is nearly alike is white, and the file stays small.
    steps = np.rint(np.clip(found, 0, 1) * (SHADES - 1)).astype(np.uint8)
    return {"similarity": _png(steps * (255 // (SHADES - 1)))}


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


def _marked(pixels: Bytes, worst: tuple[int, int], boxes: Sequence[Box]) -> bytes:
    """Draw numbered boxes, and a frame around a tile."""
    image = Pillow.fromarray(np.ascontiguousarray(pixels[::-1]))
    draw = ImageDraw.Draw(image)
    draw.fontmode = "1"
    for number, box in enumerate(boxes, 1):
        place = _corners(box, pixels.shape, BESIDE)
        draw.rectangle(place, outline=BOX)
        at = (place[0] + 1, max(place[1] - DIGIT[1], 0))
        draw.rectangle((*at, at[0] + DIGIT[0], at[1] + DIGIT[1]), fill=BOX)
        draw.text((at[0] + 2, at[1]), str(number), fill=PAPER, font=ImageFont.load_default())
    row, column = worst
    tile = _corners((row, column, row + TILE, column + TILE), pixels.shape, 1)
    draw.rectangle(tile, outline=FRAME)
    return _file(image)


def _corners(box: Box, shape: tuple[int, ...], beside: int) -> tuple[int, int, int, int]:
    """Return the left, top, right and bottom of what surrounds a box, the top row first."""
    (bottom, left, top, right), (height, width) = box, shape[:2]
    return (
        max(left - beside, 0),
        max(height - top - beside, 0),
        min(right - 1 + beside, width - 1),
        min(height - 1 - bottom + beside, height - 1),
    )


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
    return _file(Pillow.fromarray(np.ascontiguousarray(pixels[::-1])))


def _file(image: Pillow.Image) -> bytes:
    memory = io.BytesIO()
    image.save(memory, "PNG")
    return memory.getvalue()


def _shown(picture: Image) -> Image:
    return np.clip(np.nan_to_num(picture, nan=0.0, posinf=1.0, neginf=0.0), 0, 1)
