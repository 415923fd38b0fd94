"""What the notebooks' drawings share: colours that everyone can tell apart, words, numbers.

Colours are those of Okabe and Ito (Color Universal Design, 2008), in an order whose greys differ;
lines differ by their dashes as well, so that a page printed in grey can be read.
"""

from __future__ import annotations

from collections.abc import Iterable

from matplotlib.axes import Axes
from matplotlib.patches import Rectangle
from matplotlib.ticker import MaxNLocator

from grader.lab.display.words import texts

BLUE, ORANGE, GREEN, RED, SKY = "#0072b2", "#e69f00", "#009e73", "#d55e00", "#56b4e9"
GREY = "#666666"
LIGHT = ("#ffffff", "#d9d9d9")
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
    if texts().language == "fr":
        return text.replace(",", "\N{NARROW NO-BREAK SPACE}").replace(".", ",")
    return text


def digits(value: float, figures: int) -> str:
    """Return a number with that many significant figures at most, in the notebook's language."""
    return texts().number(float(f"{value:.{figures}g}"))


def triple(values: Iterable[float], decimals: int = 2) -> str:
    """Return three numbers, as (0,75 ; 0,75 ; 1) in French."""
    separator = " ; " if texts().language == "fr" else ", "
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
    axes.text(x, y, words, ha="center", va="center", fontsize=9)
