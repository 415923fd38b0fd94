"""What the notebooks' drawings share: colours that everyone can tell apart, words, numbers.

Colours are those of Okabe and Ito (Color Universal Design, 2008), two of them darker: each has a
contrast of 3 with white and with the ground of the dark theme. Lines differ by their dashes as
well, so that a page printed in grey can be read. Words are black: the page's ink.
"""

from __future__ import annotations

from collections.abc import Iterable

from matplotlib.axes import Axes
from matplotlib.patches import Rectangle
from matplotlib.ticker import MaxNLocator

from grader.lab.display.words import texts

BLUE, ORANGE, GREEN, RED, SKY = "#0072b2", "#c07f00", "#009e73", "#d55e00", "#2f8fc4"
GREY = "#666666"
INK = "black"
LIGHT = ("#ffffff", "#d9d9d9")  # the ground, and a shade of it
ON_DARK, ON_BRIGHT = "#fdfdfd", "#020202"  # over pictures and colours: the same in every theme
# The components of a colour: key of [plot] in messages/, colour, dashes.
CHANNELS = (("red", RED, "-"), ("green", GREEN, "--"), ("blue", BLUE, ":"))


def sentence(key: str, **values: object) -> str:
    """Return the words of a key such as "tp1.share", in the language of the notebook."""
    return texts().say(key, **values)


def number(value: float, decimals: int) -> str:
    """Return a number with that many decimals at most, as the notebook's language writes it."""
    text = f"{value:,.{decimals}f}"
    if "." in text:
        text = text.rstrip("0").rstrip(".")
    text = "0" if text == "-0" else text
    whole, point, part = text.partition(".")
    whole = whole.replace(",", sentence("language.thousands"))
    return f"{whole}{sentence('language.decimal') if point else ''}{part}"


def digits(value: float, figures: int) -> str:
    """Return a number with that many significant figures at most, in the notebook's language."""
    return texts().number(float(f"{value:.{figures}g}"))


def triple(values: Iterable[float], decimals: int = 2) -> str:
    """Return three numbers, as (0,75 ; 0,75 ; 1) in French."""
    separator = sentence("language.separator")
    return f"({separator.join(number(float(each), decimals) for each in values)})"


def pixel_axes(axes: Axes, columns: int, rows: int) -> None:
    """Set axes for a small image seen pixel by pixel: (0, 0) at the bottom left, whole numbers."""
    axes.set(xlim=(-0.5, columns - 0.5), ylim=(-0.5, rows - 0.5), aspect="equal")
    axes.set(xlabel=sentence("plot.column"), ylabel=sentence("plot.row"))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(nbins=10, integer=True))


def box(axes: Axes, x: float, y: float, words: str, color: str) -> None:
    """Draw a pixel as a square of side 1 around (x, y), with words in it."""
    axes.add_patch(Rectangle((x - 0.5, y - 0.5), 1, 1, facecolor=color, edgecolor=GREY))
    ink = INK if color in LIGHT else ON_BRIGHT
    axes.text(x, y, words, ha="center", va="center", fontsize=9, color=ink)


def cross(axes: Axes, x: float, y: float) -> None:
    """Mark a point of a picture, whatever its colours."""
    axes.plot(x, y, "+", color=ON_DARK, ms=16, mew=3)
    axes.plot(x, y, "+", color=ON_BRIGHT, ms=14, mew=1)
