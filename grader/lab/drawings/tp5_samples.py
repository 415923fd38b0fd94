"""Drawings for the samples of TP5's notebook: means of a pixel, and their distance to the truth.

They draw what the student's own functions answer.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from grader.lab.bridge.core import Core
from grader.lab.display import plots
from grader.lab.display.card import Shown
from grader.lab.display.picture import draw, figure, new_figure, show
from grader.lab.display.plots import BLUE, GREY, number, sentence

Array = npt.NDArray[Any]
Zone = tuple[int, int, int, int]  # first column, first row, columns, rows

FRAME = (640, 360)  # pixels of the picture whose zones these are
EDGE: Zone = (148, 76, 56, 42)  # the red ball of scene 0
HIGHLIGHT: Zone = (179, 99, 16, 12)  # on that ball
GLASS: Zone = (196, 124, 56, 42)  # the ball of glass of scene 7
SIDES, BEST = (1, 2, 3, 4, 6, 8), 20  # samples per side of a pixel; those of the truth


def _grid(zone: Zone) -> tuple[Array, Array]:
    """Return the columns and the rows of the pixels of a zone, each of shape (rows, columns)."""
    i0, j0, columns, rows = zone
    i, j = np.meshgrid(np.arange(i0, i0 + columns), np.arange(j0, j0 + rows))
    return i, j


def _corners(zone: Zone) -> Zone:
    """Return the first column and row of a zone, and the last ones."""
    i0, j0, columns, rows = zone
    return (i0, j0, i0 + columns - 1, j0 + rows - 1)


def _placed(zone: Zone, colors: Array) -> Array:
    """Return a whole picture that holds the colours of a zone, black elsewhere."""
    picture = np.zeros((FRAME[1], FRAME[0], 3))
    picture[_grid(zone)[::-1]] = colors
    return picture


def _averaged(core: Core, zone: Zone, side: int) -> Array:
    """Return the student's pixel_color of a zone of the scene in use, `side` x `side` samples."""
    core.options(samples=side)
    try:
        return np.asarray(core.pixel_color(*_grid(zone), size=FRAME))
    finally:
        core.options()


def _traced(core: Core, zone: Zone, side: int) -> Array:
    """Return the student's trace_ray of `side` x `side` places in each pixel of scene 0's zone.

    Its shape is (rows, columns, side, side, 3).
    """
    core.scene(0)
    i, j = _grid(zone)
    place = (np.arange(side) + 0.5) / side
    x = i[..., None, None] + place
    y = j[..., None, None] + place[:, None]
    rays = core.camera_ray(*np.broadcast_arrays(x, y), size=FRAME)
    return np.asarray(core.trace_ray(rays, size=FRAME))


def edges(core: Core, samples: int = 1) -> Shown:
    """Show the red ball of scene 0, pixel by pixel: means of what the student's trace_ray gives."""
    picture = _placed(EDGE, np.clip(_traced(core, EDGE, samples), 0, 1).mean(axis=(2, 3)))
    title = sentence("tp5.edges_title", side=samples, count=samples**2)
    return show(
        picture, title, zoom=_corners(EDGE), grid=False, alt=sentence("tp5.edges_alt", title=title)
    )


def clamp_order(core: Core, side: int = 3) -> Shown:
    """Compare two means of the same samples on a highlight: clamped before, clamped after."""
    colors = _traced(core, HIGHLIGHT, side)
    drawn, axes = new_figure(2, 1, (9.5, 4.2))
    before = np.clip(colors, 0, 1).mean(axis=(2, 3))
    after = np.clip(colors.mean(axis=(2, 3)), 0, 1)
    whites = []
    for each, picture, key in zip(axes, (before, after), ("before", "after"), strict=True):
        placed = _placed(HIGHLIGHT, picture)
        draw(each, placed, sentence(f"tp5.{key}"), zoom=_corners(HIGHLIGHT), grid=False)
        whites.append(number(int((picture.min(axis=-1) > 0.99).sum()), 0))
    top = number(float(colors.max()), 1)
    drawn.suptitle(sentence("tp5.brightest", top=top), fontsize=10)
    return figure(drawn, sentence("tp5.clamp_alt", before=whites[0], after=whites[1], top=top))


def error_curve(core: Core, scene: int = 0) -> Shown:
    """Draw the error of a zone of the picture against the number of samples, and its slope."""
    zone = GLASS if scene == 7 else EDGE
    core.scene(scene)
    truth = _averaged(core, zone, BEST)
    errors = [_rms(_averaged(core, zone, side) - truth) for side in SIDES]
    counts = np.array([side**2 for side in SIDES])
    drawn, (seen, curve) = new_figure(2, 1, (9.5, 3.8))
    picture = _placed(zone, _averaged(core, zone, 2))
    draw(seen, picture, sentence("tp5.zone", scene=scene), zoom=_corners(zone), grid=False)
    curve.set(xlabel=sentence("tp5.samples"), ylabel=sentence("tp5.error"))
    if min(errors) > 0:
        slope = float(np.polyfit(np.log(counts), np.log(errors), 1)[0])
        curve.loglog(counts, errors, "o-", color=BLUE)
        curve.loglog(counts, errors[0] / np.sqrt(counts), ":", color=GREY, label="-1/2")
        curve.loglog(counts, errors[0] / counts, "--", color=GREY, label="-1")
        curve.set_xticks(counts, [str(each) for each in counts])
        curve.set_xticks([], minor=True)
        curve.legend(title=sentence("tp5.slopes"), fontsize=8)
        title = sentence("tp5.slope", slope=number(slope, 2))
    else:
        title = sentence("tp5.no_error")
    curve.set_title(title)
    told = " ; ".join(plots.digits(each, 2) for each in errors)
    return figure(drawn, sentence("tp5.error_alt", scene=scene, errors=told, title=title))


def _rms(difference: Array) -> float:
    return float(np.sqrt(np.mean(np.square(difference, dtype=np.float64))))
