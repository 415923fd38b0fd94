"""From colours to PNG files, and the contact sheet of many pictures."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont

from grader.files import write_whole

Bytes = npt.NDArray[np.uint8]

# Pixels.
COLUMNS, THUMB, GAP, LINE = 4, 480, 16, 22


@dataclass(frozen=True)
class SheetPicture:
    """A picture and its two captions; pixels of shape (height, width, 3), the top row first."""

    captions: tuple[str, ...]
    pixels: Bytes


def to_pixels(image: npt.NDArray[Any], width: int, height: int) -> Bytes:
    """Return an image as ./mrt writes it: clamped, truncated to bytes, the top row first.

    Parameters
    ----------
    image : float32 array of shape (height * width, 3)
        The bottom row first; 1 is full brightness.

    Returns
    -------
    array of shape (height, width, 3)
    """
    levels = (np.clip(image, 0, 1) * np.float32(255)).astype(np.uint8)
    return levels.reshape(height, width, 3)[::-1]


def save(picture: Image.Image, path: Path) -> None:
    """Write a PNG file whole or not at all."""
    out = io.BytesIO()
    picture.save(out, format="png")
    write_whole(path, out.getvalue())


def contact_sheet(drawn: Sequence[SheetPicture]) -> Image.Image:
    """Return all the pictures side by side, each above its captions."""
    height, width, _ = drawn[0].pixels.shape
    thumb = THUMB, round(THUMB * height / width)
    step = THUMB + GAP, thumb[1] + 2 * LINE + GAP
    rows = -(-len(drawn) // COLUMNS)
    sheet = Image.new("RGB", (COLUMNS * step[0] + GAP, rows * step[1] + GAP), "white")
    pen = ImageDraw.Draw(sheet)
    # Pillow's own font lacks the accents; matplotlib brings one that has them.
    font = ImageFont.truetype(str(Path(matplotlib.get_data_path(), "fonts/ttf/DejaVuSans.ttf")), 15)
    for k, each in enumerate(drawn):
        x, y = GAP + k % COLUMNS * step[0], GAP + k // COLUMNS * step[1]
        sheet.paste(Image.fromarray(each.pixels).resize(thumb, Image.Resampling.LANCZOS), (x, y))
        for line, color, caption in zip(
            (3, LINE), ("black", "dimgray"), each.captions, strict=True
        ):
            pen.text((x, y + thumb[1] + line), caption, font=font, fill=color)
    return sheet
