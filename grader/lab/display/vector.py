"""A matplotlib figure as SVG inside the page: sharp at any zoom, in the colours of its theme.

Black is the page's ink and white its ground, whatever the theme is and when it changes; there is no
sheet behind. The palette of `plots` is seen on light ground and on dark.
"""

from __future__ import annotations

import io
import re
from typing import TYPE_CHECKING

from grader.lab.display.card import escape
from grader.lab.display.plots import GREY

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Of matplotlib: the same names inside the same drawing; grids that are seen on any ground.
SETTINGS = {"svg.hashsalt": "mrt", "svg.fonttype": "path", "grid.color": GREY}
DPI = 200  # of what is no line in it: a colour scale
PX = 96 / 72  # CSS pixels in a point
# What a theme changes, as matplotlib writes it; without a colour, SVG fills with black.
_COLORS = (
    (r"\b(fill|stroke): #000000", r"\1: currentColor"),
    (r"\b(fill|stroke): #ffffff", r"\1: var(--jp-layout-color0, #ffffff)"),
    (r"\b(fill|stroke): #d9d9d9", r"\1: #808080; \1-opacity: 0.3"),
    (r'\bfill="#d9d9d9"', 'fill="#808080" fill-opacity="0.3"'),
)
_FRAME = (
    r'<svg role="img" aria-label="{alt}" class="mrt-drawing" fill="currentColor" '
    r'style="stroke-linejoin:round;stroke-linecap:butt;max-width:100%;height:auto" '
)
_NO_DATA = dict.fromkeys(("Date", "Creator", "Format", "Type"))
_IMAGE = re.compile(r'<image\b[^>]*?transform="matrix\(([\d.]+) [^>]*>')
_SHARP = re.compile(r' style="image-rendering:[^"]*"')


def svg(drawn: Figure, alt: str) -> str:
    """Return a figure as an `<svg>` element; `alt` says what is to be seen."""
    from matplotlib import rc_context

    _take_sheets_off(drawn)
    out = io.StringIO()
    with rc_context(SETTINGS):
        drawn.savefig(out, format="svg", dpi=DPI, metadata=_NO_DATA)
    _, _, inside = out.getvalue().partition("<svg ")
    # Its style sheet would hold for the whole page; its ids are those of every other figure.
    inside = re.sub(r"<defs>\s*<style.*?</defs>|<!--.*?-->", "", inside, count=0, flags=re.S)
    inside = re.sub(r'<g id="([a-zA-Z0-9.]+)_\d+"', r'<g class="mrt-\1"', inside)
    for before, after in _COLORS:
        inside = re.sub(before, after, inside)
    return _FRAME.format(alt=escape(alt)) + _IMAGE.sub(_smooth, inside)


def _smooth(match: re.Match[str]) -> str:
    """Let an image that has more pixels than its place be scaled, rather than lose columns."""
    return _SHARP.sub("", match[0]) if float(match[1]) * PX < 1 else match[0]


def _take_sheets_off(drawn: Figure) -> None:
    from matplotlib.colors import to_rgb

    drawn.patch.set_visible(False)
    for axes in drawn.axes:
        if to_rgb(axes.get_facecolor()) == (1, 1, 1):
            axes.patch.set_visible(False)
        for axis in (getattr(axes, name, None) for name in ("xaxis", "yaxis", "zaxis")):
            if pane := getattr(axis, "pane", None):  # the walls of a drawing in space
                pane.set_visible(False)
        if legend := axes.get_legend():
            legend.get_frame().set_edgecolor("none")
