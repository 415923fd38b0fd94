"""What every drawing gets before it is shown: capitals for its titles, its language's decimals."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from matplotlib.ticker import ScalarFormatter

from grader.lab.display.card import capital
from grader.lab.display.words import texts

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class DecimalTicks(ScalarFormatter):
    """matplotlib's own numbers, with the decimal sign of the language."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        """Return a tick's label."""
        return super().__call__(x, pos).replace(".", texts().say("language.decimal"))


def dress(drawn: Figure) -> None:
    """Give a figure its titles and ticks as the notebook's language writes them."""
    for each in [*(axes.title for axes in drawn.axes), *drawn.texts]:  # and the title of all
        each.set_text(capital(each.get_text()))
    for axes in drawn.axes:
        for axis in (axes.xaxis, axes.yaxis, getattr(axes, "zaxis", None)):
            if axis is not None:
                _with_decimals(axis)


def _with_decimals(axis: Any) -> None:
    if type(axis.get_major_formatter()) is ScalarFormatter:
        axis.set_major_formatter(DecimalTicks())
