"""Drawings for TP1's notebook: the table that an image is, interpolation, a rectangle, a disc."""

from __future__ import annotations

import resource
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.patches import Rectangle

from grader.lab.display.card import Shown, table
from grader.lab.display.picture import figure, new_figure
from grader.lab.display.plots import (
    BLUE,
    CHANNELS,
    GREY,
    LIGHT,
    ORANGE,
    box,
    number,
    pixel_axes,
    sentence,
    triple,
)

Array = npt.NDArray[Any]

COLUMNS, ROWS = 6, 4  # of the small image of memory_strip
WIDTH, HEIGHT = 1280, 720  # of the handout's image
COLOR_BYTES = 12  # three floats
TOP, BOTTOM = (0.0, 0.0, 1.0), (1.0, 1.0, 1.0)  # the colours of ./mrt 2


def memory_strip(i: int = 0, j: int = 0) -> Shown:
    """Show a small image and its memory, with the box of pixel (i, j) marked in both.

    Column `i` may be 6, one too far: the box is then that of another pixel.
    """
    k = j * COLUMNS + i
    landing = k % COLUMNS, k // COLUMNS
    alt = sentence("tp1.memory_alt", i=i, j=j, k=k, column=landing[0], row=landing[1])
    drawn, (grid, strip) = new_figure(1, 2, (7.5, 4.6), height_ratios=(4, 1))
    pixel_axes(grid, COLUMNS + (i >= COLUMNS), ROWS)
    for index in range(COLUMNS * ROWS):
        column, row = index % COLUMNS, index // COLUMNS
        shade = LIGHT[row % 2]
        marked = index == k
        box(grid, column, row, str(index), ORANGE if marked else shade)
        box(strip, index, 0, str(index), ORANGE if marked else shade)
    if i >= COLUMNS:
        grid.add_patch(Rectangle((i - 0.5, j - 0.5), 1, 1, fill=False, ls="--", ec=GREY))
        grid.text(i, j, "?", ha="center", va="center")
    grid.set_title(f"i = {i},  j = {j}")
    strip.set(xlim=(-0.5, COLUMNS * ROWS - 0.5), ylim=(-0.5, 0.5), yticks=[], xlabel="k")
    strip.set_title(f"k = j × w + i = {j} × {COLUMNS} + {i} = {k}")
    return figure(drawn, alt)


def interpolation(t: float = 0.25) -> Shown:
    """Show what becomes of the two shares, t of c1 and 1 - t of c2, and of their mix."""
    mixed = t * np.array(TOP) + (1 - t) * np.array(BOTTOM)
    drawn, (shares, colors) = new_figure(2, 1, (7.5, 3.4))
    shares.plot([0, 1], [0, 1], color=BLUE, label=sentence("tp1.share_of_top"))
    shares.plot([0, 1], [1, 0], color=ORANGE, ls="--", label=sentence("tp1.share_of_bottom"))
    shares.plot([t, t], [t, 1 - t], "o", color="black")
    shares.axvline(t, color=GREY, lw=0.8)
    shares.set(xlabel="t", ylabel=sentence("tp1.share"), ylim=(-0.05, 1.05))
    shares.legend(loc="lower center", bbox_to_anchor=(0.5, 1), fontsize=8)
    steps = np.linspace(0, 1, 256)[:, None, None]
    ramp = steps * np.array(TOP) + (1 - steps) * np.array(BOTTOM)
    colors.imshow(ramp, origin="lower", extent=(0, 1, 0, 1), aspect="auto")
    colors.axhline(t, color="black", lw=1)
    colors.text(0.5, t, triple(mixed), ha="center", bbox={"fc": "white", "ec": GREY}, fontsize=9)
    colors.set(xticks=[], ylabel="t")
    return figure(drawn, sentence("tp1.mix_alt", t=number(t, 2), color=triple(mixed)))


def division_table(height: int = 360) -> Shown:
    """Compare the quotient of two integers with that of two floats, for some rows."""
    rows = [0, height // 4, height // 2, 3 * height // 4, height - 1]
    heads = [
        "j",
        f"j / HEIGHT ({sentence('tp1.integers')})",
        f"j / HEIGHT ({sentence('tp1.floats')})",
    ]
    return table(heads, [[str(j), str(j // height), number(j / height, 3)] for j in rows])


def column_profile(img: npt.ArrayLike) -> Shown:
    """Draw the red, green and blue of the middle column of a picture, from bottom to top.

    Parameters
    ----------
    img : array of shape (height, width, 3)
        A picture, the bottom row first.
    """
    pixels = np.asarray(img)
    height, width, _ = pixels.shape
    column = pixels[:, width // 2]
    alt = sentence("tp1.profile_alt", bottom=triple(column[0]), top=triple(column[-1]))
    drawn, axes = new_figure(1, 1, (5.5, 3.6))
    for channel, (key, color, style) in enumerate(CHANNELS):
        line = np.asarray(column[:, channel])
        axes.plot(
            line, np.arange(height), color=color, ls=style, lw=2, label=sentence(f"plot.{key}")
        )
    axes.set(xlim=(-0.05, 1.05), xlabel=sentence("plot.level"), ylabel=sentence("plot.row"))
    axes.legend(fontsize=8)
    return figure(drawn, alt)


def rectangle_grid(first: tuple[int, int], second: tuple[int, int]) -> Shown:
    """Show the pixels of a rectangle, both corners included, and their number."""
    (i1, j1), (i2, j2) = first, second
    count = (abs(i2 - i1) + 1) * (abs(j2 - j1) + 1)
    drawn, axes = new_figure(1, 1, (5, 3.4))
    pixel_axes(axes, max(i1, i2) + 3, max(j1, j2) + 2)
    for i in range(max(i1, i2) + 3):
        for j in range(max(j1, j2) + 2):
            corner = {first: "p1", second: "p2"}.get((i, j), "")
            inside = min(i1, i2) <= i <= max(i1, i2) and min(j1, j2) <= j <= max(j1, j2)
            box(axes, i, j, corner, ORANGE if corner else LIGHT[inside])
    axes.set_title(f"{abs(i2 - i1) + 1} × {abs(j2 - j1) + 1} = {count} pixels")
    return figure(drawn, sentence("tp1.rectangle_alt", count=count))


def distance_map(radius: float = 4.0, squared: bool = False) -> Shown:
    """Write in each pixel its distance to the centre, or the square of it; the disc is coloured.

    Parameters
    ----------
    radius : float
        Of the disc, in pixels.
    squared : bool
        Whether to write squares, and compare them with the square of the radius.
    """
    alt = sentence("tp1.distance_alt", radius=number(radius, 2))
    drawn, axes = new_figure(1, 1, (6.5, 5.2))
    half = 5
    pixel_axes(axes, 2 * half + 1, 2 * half + 1)
    for i in range(2 * half + 1):
        for j in range(2 * half + 1):
            square = (i - half) ** 2 + (j - half) ** 2
            words = str(square) if squared else number(square**0.5, 1)
            box(axes, i, j, words, ORANGE if square < radius**2 else LIGHT[0])
    limit = f"r² = {number(radius**2, 2)}" if squared else f"r = {number(radius, 2)}"
    axes.set_title(f"{'dx² + dy²' if squared else '√(dx² + dy²)'}  <  {limit}")
    return figure(drawn, alt)


def circle_tests(radius: int = 64) -> Shown:
    """Count the pixels of the image, of a disc's bounding box, and of the disc."""
    side = np.arange(-radius, radius + 1)
    inside = int((side[:, None] ** 2 + side**2 < radius**2).sum())
    counts = (WIDTH * HEIGHT, side.size**2, inside)
    told = [number(each, 0) for each in counts]
    alt = sentence("tp1.tests_alt", image=told[0], box=told[1], disc=told[2])
    drawn, axes = new_figure(1, 1, (7.5, 2.4))
    names = [sentence(f"tp1.{key}") for key in ("whole_image", "box", "disc")]
    bars = axes.barh(names, counts, color=[LIGHT[1], ORANGE, BLUE], edgecolor=GREY)
    axes.bar_label(bars, told, padding=4)
    axes.invert_yaxis()
    axes.set(xlim=(0, WIDTH * HEIGHT * 1.18), xticks=[], xlabel=sentence("tp1.pixels_tested"))
    ratio = number(counts[0] / counts[1], 1)
    axes.set_title(sentence("tp1.ratio", radius=radius, ratio=ratio))
    return figure(drawn, alt)


def memory_sizes() -> Shown:
    """Compare the size of an image with that of the stack of this machine."""
    stack, _ = resource.getrlimit(resource.RLIMIT_STACK)
    room = sentence("tp1.no_limit") if stack == resource.RLIM_INFINITY else f"{number(stack, 0)}"
    image = WIDTH * HEIGHT * COLOR_BYTES
    rows = [
        ["color", str(COLOR_BYTES)],
        [f"color[{WIDTH} * {HEIGHT}]", number(image, 0)],
        [sentence("tp1.stack"), room],
    ]
    return table(["", sentence("tp1.bytes")], rows)
