"""Drawings for the first minutes of TP2: two vectors and their products."""

from __future__ import annotations

import numpy as np

from grader.lab.display.card import Shown
from grader.lab.display.picture import figure, new_figure
from grader.lab.display.plots import BLUE, GREY, ORANGE, RED, number, sentence


def products(angle: int = 60, length: float = 1.0) -> Shown:
    """Show u, of length 1, and v; the projection of v on u is their dot product.

    Parameters
    ----------
    angle : int
        Between u and v, degrees.
    length : float
        Of v.
    """
    turn = np.radians(angle)
    v = length * np.array([np.cos(turn), np.sin(turn)])
    dot, cross = (number(float(each), 2) for each in (v[0], v[1]))
    drawn, axes = new_figure(1, 1, (6.4, 3.6))
    axes.axhline(0, color=GREY, lw=0.8)
    axes.plot([0, v[0]], [0, 0], color=RED, lw=6, solid_capstyle="butt")
    axes.plot([v[0], v[0]], v * (0, 1), color=GREY, ls="--")
    for end, name, color in ((np.array([1.0, 0.0]), "u", BLUE), (v, "v", ORANGE)):
        axes.annotate("", end, (0, 0), arrowprops={"arrowstyle": "->", "color": color, "lw": 2.5})
        axes.text(*(1.1 * end + (0, 0.08)), name, weight="bold", ha="center")
    axes.set(xlim=(-2.3, 2.3), ylim=(-0.3, 2.3), aspect="equal", xlabel="x", ylabel="y")
    axes.set_title(f"u . v = {dot}      |u × v| = {cross}")
    values = {"angle": angle, "length": number(length, 2), "dot": dot, "cross": cross}
    return figure(drawn, sentence("tp2.products_alt", **values))
