"""Pictures: tables of colours whose row 0 is at the bottom, and how a cell shows them."""

from __future__ import annotations

import base64
import io
import logging
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from PIL import Image

from grader.checking.shapes import Size
from grader.lab.display.card import Shown, escape
from grader.lab.display.vectors import numbers
from grader.lab.display.words import say, texts

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = npt.NDArray[Any]

FIGURE_INCHES = (7.0, 4.6)
NOT_A_NUMBER = (255, 0, 255)  # the colour of a pixel that holds a NaN
MAP = "cividis"  # safe for colour-blind readers, and grows lighter in grey
MOST_LINES = 80  # pixels across, up to which a grid is drawn between them

# The first time, it would say in red that it lists the machine's fonts.
logging.getLogger("matplotlib.font_manager").setLevel(logging.ERROR)


class Picture(np.ndarray[Any, Any]):
    """An array (height, width, 3) of colours; `img[j, i]` is column i, row j from the bottom.

    A cell that ends with it shows it.
    """

    @property
    def pixels(self) -> Size:
        """Its width and height, in pixels."""
        return (self.shape[1], self.shape[0])

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, str]:
        """Return the picture, or the numbers of a part that is none."""
        if self.ndim != 3 or self.shape[2] != 3:
            return {"text/plain": repr(self)}
        shown = image(self)
        return {"text/html": shown.html, "text/plain": shown.text}

    def __repr__(self) -> str:
        if self.ndim == 3 and self.shape[2] == 3:
            return described(self)
        return numbers(self)

    __str__ = __repr__


def black(size: Size) -> Picture:
    """Return a black picture (width, height)."""
    return np.zeros((size[1], size[0], 3), np.float32).view(Picture)


def levels(picture: Array) -> npt.NDArray[np.uint8]:
    """Return colours as the picture file holds them, row 0 at the top; NaN stands out."""
    flat = np.asarray(picture, np.float32)
    shown = (np.clip(np.nan_to_num(flat), 0, 1) * 255).astype(np.uint8)
    shown[np.isnan(flat).any(axis=2)] = NOT_A_NUMBER
    return np.ascontiguousarray(shown[::-1])


def png(picture: Array) -> bytes:
    """Return a picture as a PNG file."""
    out = io.BytesIO()
    Image.fromarray(levels(picture)).save(out, "PNG", compress_level=1)
    return out.getvalue()


def described(picture: Array, title: str = "") -> str:
    """Return a picture in words: its size, its title, and how many pixels are no numbers."""
    height, width = picture.shape[:2]
    key = "picture_titled" if title else "picture"
    text = say(key, width=width, height=height, title=title)
    wrong = int(np.isnan(np.asarray(picture, np.float32)).any(axis=2).sum())
    return f"{text} {say('nan_pixels', count=wrong)}" if wrong else text


def encoded(content: bytes) -> str:
    """Return the content of a file as text, in base64."""
    return base64.b64encode(content).decode("ascii")


def tag(content: bytes, alt: str) -> Shown:
    """Return a PNG file as an image that a cell shows, with its text for who cannot see it."""
    source = f"data:image/png;base64,{encoded(content)}"
    return Shown(
        f'<img src="{source}" alt="{escape(alt)}" style="max-width:100%;height:auto">', alt
    )


def image(picture: Array, alt: str = "") -> Shown:
    """Return a picture, pixel for pixel."""
    return tag(png(picture), alt or described(picture))


def new_figure(
    columns: int = 1, rows: int = 1, inches: tuple[float, float] = FIGURE_INCHES, **kinds: Any
) -> tuple[Figure, Any]:
    """Return a matplotlib figure and its axes; `kinds` as in plt.subplots.

    It belongs to no window, so that nothing has to be closed.
    """
    from matplotlib import rc_context
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    from grader.lab.display.vector import SETTINGS

    figure = Figure(figsize=inches, layout="constrained")
    FigureCanvasSVG(figure)
    with rc_context(SETTINGS):
        return figure, figure.subplots(rows, columns, **kinds)


def figure(drawn: Figure, alt: str) -> Shown:
    """Return a matplotlib figure as what a cell shows; `alt` says what is to be seen."""
    from grader.lab.display.dressing import dress
    from grader.lab.display.vector import svg

    dress(drawn)
    return Shown(svg(drawn, alt), alt)


def show(
    img: Array,
    title: str | None = None,
    *,
    grid: bool | None = None,
    zoom: tuple[int, int, int, int] | None = None,
    label: str = "",
    alt: str = "",
) -> Shown:
    """Return a picture with its axes in pixels, row 0 at the bottom and (0, 0) marked.

    Parameters
    ----------
    img : array, shape (height, width, 3), or (height, width) for a map of numbers
    title : what stands above
    grid : whether lines part the pixels; by default where few enough are shown
    zoom : (i0, j0, i1, j1), the columns and rows to show, both ends included
    label : of a map's scale, with its unit
    alt : what is to be seen, for who cannot see it; by default the title and the size
    """
    drawn, axes = new_figure()
    draw(axes, img, title, grid=grid, zoom=zoom, label=label)
    text = alt or _alt(img, title or label, zoom)
    return figure(drawn, text)


def draw(
    axes: Axes,
    img: Array,
    title: str | None = None,
    *,
    grid: bool | None = None,
    zoom: tuple[int, int, int, int] | None = None,
    label: str = "",
    limits: tuple[float | None, float | None] = (None, None),
) -> None:
    """Draw a picture, or a map of numbers between `limits`, on axes of matplotlib."""
    from matplotlib.ticker import MaxNLocator

    array = np.asarray(img)
    height, width = array.shape[:2]
    i0, j0, i1, j1 = zoom or (0, 0, width - 1, height - 1)
    if array.ndim == 3:
        axes.imshow(levels(array)[::-1], origin="lower", interpolation="none")
    else:
        low, high = limits
        axes.set_facecolor("0.85")  # where there is no number
        drawn = axes.imshow(
            array, origin="lower", interpolation="none", cmap=MAP, vmin=low, vmax=high
        )
        axes.figure.colorbar(drawn, ax=axes, label=label, shrink=0.8)
    axes.set_xlim(i0 - 0.5, i1 + 0.5)
    axes.set_ylim(j0 - 0.5, j1 + 0.5)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator("auto", integer=True))
    axes.set_xlabel(say("axis_i"))
    axes.set_ylabel(say("axis_j"))
    axes.set_title(title or "")
    if i0 <= 0 <= i1 and j0 <= 0 <= j1:
        _mark_origin(axes)
    if grid or (grid is None and zoom is not None and i1 - i0 < MOST_LINES):
        _rule(axes, i0, j0, i1, j1)


def _mark_origin(axes: Axes) -> None:
    axes.annotate(
        "(0, 0)",
        (0, 0),
        (10, 8),
        textcoords="offset points",
        fontsize=9,
        bbox={"boxstyle": "round,pad=0.2", "fc": "white", "ec": "0.4", "alpha": 0.85},
        arrowprops={"arrowstyle": "->", "color": "0.4"},
    )


def _rule(axes: Axes, i0: int, j0: int, i1: int, j1: int) -> None:
    axes.set_xticks(np.arange(i0, i1 + 2) - 0.5, minor=True)
    axes.set_yticks(np.arange(j0, j1 + 2) - 0.5, minor=True)
    axes.grid(which="minor", color="0.5", linewidth=0.5)
    axes.tick_params(which="minor", length=0)


def _alt(img: Array, title: str, zoom: tuple[int, int, int, int] | None) -> str:
    array = np.asarray(img)
    if array.ndim == 3:
        text = described(array, title)
    else:
        low, high = (
            (np.nanmin(array), np.nanmax(array)) if np.isfinite(array).any() else (np.nan,) * 2
        )
        text = say("map", title=title, low=_told(low), high=_told(high))
    return f"{text} {say('zoom', zone=zoom)}" if zoom else text


def _told(value: float) -> str:
    return texts().number(float(f"{value:.3g}"))
