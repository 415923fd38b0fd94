"""Scene 0 as the submission draws it, small, in a terminal: two pixels in each cell."""

from __future__ import annotations

import contextlib
import sys
from typing import TextIO

import numpy as np
import numpy.typing as npt
from PIL import Image
from rich.color import Color
from rich.console import Console
from rich.style import Style
from rich.text import Text

from grader.course.sizes import UNIT
from grader.execution.libraries import Libraries
from grader.execution.library_set import NotBuilt
from grader.execution.records import Limits
from grader.execution.session_socket import Died, MachineError, Missing

FILE = "raytracer.c"  # without which no scene is drawn
SCENE = 0
SECONDS = 1.0
COLUMNS = 64
HALF = "▀"
ENOUGH_COLOURS = ("256", "truecolor")

Pixels = npt.NDArray[np.uint8]


def show(libraries: Libraries, out: TextIO | None = None) -> None:
    """Draw the scene and print it; nothing where a terminal cannot show it, or nothing is drawn."""
    out = out or sys.stdout
    if not can_show(out):
        return
    # What is wrong is told by the checks.
    with contextlib.suppress(OSError, NotBuilt, Died, Missing, MachineError):
        pixels = _drawn(libraries)
        if pixels.min() != pixels.max():
            console = Console(file=out, highlight=False, soft_wrap=True)
            console.print(cells(pixels, min(COLUMNS, console.width)))


def can_show(out: TextIO) -> bool:
    """Say whether that is a terminal with the letters and the colours for a picture."""
    console = Console(file=out)
    enough = console.color_system in ENOUGH_COLOURS and not console.no_color
    return out.isatty() and enough and "utf" in console.encoding


def _drawn(libraries: Libraries) -> Pixels:
    """Return what raytrace() draws, row 0 at the top. Raises what a session does."""
    width, height = UNIT
    with libraries.lend(FILE).unit(UNIT).session(Limits(cpu=SECONDS)) as session:
        session.call("setup_scene", SCENE)
        session.set("output_image", np.zeros((width * height, 3), np.float32))
        session.call("raytrace")
        colours = np.nan_to_num(session.get("output_image").reshape(height, width, 3))
    return (np.clip(colours[::-1], 0, 1) * 255).astype(np.uint8)


def cells(pixels: Pixels, columns: int) -> Text:
    """Return a picture as lines of so many cells: above the colour of the letter, below the other.

    Its height is that of an even number of pixels.
    """
    rows = round(pixels.shape[0] * columns / pixels.shape[1] / 2)
    small = Image.fromarray(pixels).resize((columns, 2 * rows), Image.Resampling.BOX)
    pairs = np.asarray(small).reshape(rows, 2, columns, 3).transpose(0, 2, 1, 3).tolist()
    lines = [Text(end="") for _ in pairs]
    for line, row in zip(lines, pairs, strict=True):
        for above, below in row:
            line.append(HALF, Style(color=Color.from_rgb(*above), bgcolor=Color.from_rgb(*below)))
    return Text("\n").join(lines)
