"""slider(function, epsilon=(0, 0.1)): a picture that follows its parameters."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from grader.lab.display.card import Shown, card, code, escape
from grader.lab.display.controls import beside
from grader.lab.display.picture import Picture, image
from grader.lab.display.stopped import Stopped
from grader.lab.display.words import texts

Range = tuple[Any, ...]


class Slider:
    """Sliders above what a function returns for their values.

    Without a front end, what it returns for the values at the start stands there as a picture.
    """

    def __init__(self, function: Callable[..., Any], ranges: Mapping[str, Any]) -> None:
        self._function, self._ranges = function, dict(ranges)

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, Any]:
        """Return the sliders, and beside them what a page without a kernel shows."""
        box, shown = self._box()
        return {
            **box._repr_mimebundle_(),
            "text/html": shown.html,
            "text/plain": shown.text,
        }

    def __repr__(self) -> str:
        return _drawn(self._function, {k: _start(v) for k, v in self._ranges.items()}).text

    def _box(self) -> tuple[Any, Shown]:
        import ipywidgets  # type: ignore[import-untyped]

        controls = {name: _control(name, each) for name, each in self._ranges.items()}

        def draw() -> Shown:
            return _drawn(self._function, {name: each.value for name, each in controls.items()})

        shown = draw()
        area = ipywidgets.HTML(value=shown.html)

        def follow(change: Any) -> None:
            # The browser holds back what comes while this runs, and sends the latest value only.
            area.value = draw().html

        for each in controls.values():
            each.observe(follow, names="value")
        return beside(*controls.values(), area), shown


def slider(function: Callable[..., Any], **ranges: Range | Any) -> Slider:
    """Return sliders for the arguments of a function that returns a picture or what `show` gives.

    A range is (first, last) or (first, last, start): whole numbers when both are; a list of
    choices, which the slider puts in order; or True or False. It starts at `start`, or else at the
    first.
    """
    return Slider(function, ranges)


def _start(each: Any) -> Any:
    if isinstance(each, tuple):
        return each[2] if len(each) > 2 else each[0]
    return each[0] if isinstance(each, list) else each


def _control(name: str, each: Any) -> Any:
    import ipywidgets

    wide = {"description": name, "style": {"description_width": "initial"}}
    if isinstance(each, bool):
        return ipywidgets.Checkbox(value=each, **wide)
    if isinstance(each, list):
        return _choice(sorted(each), each[0], wide)
    first, last = each[:2]
    if isinstance(first, int) and isinstance(last, int):
        return ipywidgets.IntSlider(min=first, max=last, value=_start(each), **wide)
    return _choice(grid(first, last, _start(each)), _start(each), wide)


def _choice(values: Sequence[Any], start: Any, wide: Mapping[str, Any]) -> Any:
    """Return a slider along values, each written as the language writes it.

    Numbers go there as they are: those that a browser computes from a step may miss them a little.
    """
    import ipywidgets

    options = [(_told(each), each) for each in values]
    return ipywidgets.SelectionSlider(options=options, value=start, **wide)


def grid(first: float, last: float, start: float) -> list[float]:
    """Return numbers from the first to the last, in round steps that meet both, and the start."""
    low, high, middle = (Fraction(str(each)) for each in (first, last, start))
    for step in _round_steps(high - low):
        if (high - low) % step == 0 and (middle - low) % step == 0:
            return [float(low + k * step) for k in range(int((high - low) / step) + 1)]
    raise ValueError(f"no round step leads from {first} to {last} by {start}")


def _round_steps(length: Fraction) -> Iterator[Fraction]:
    """Yield 0.05, 0.02, 0.01, ...: those that part a length in 20 to 2000, the coarsest first."""
    for power in range(6, -10, -1):
        for digit in (5, 2, 1):
            step = digit * Fraction(10) ** power
            if 20 <= length / step <= 2000:
                yield step


def _drawn(function: Callable[..., Any], values: Mapping[str, Any]) -> Shown:
    """Return what the function gives as HTML and text, whatever it is."""
    try:
        result = function(**values)
    except Stopped as error:
        # In a widget JupyterLab does not follow links to files: the text alone.
        return card(code(error.shown.text), error.shown.text, "bad")
    if isinstance(result, Shown):
        return result
    if isinstance(result, Picture) and result.ndim == 3:
        told = ", ".join(f"{name} = {_told(value)}" for name, value in values.items())
        return image(result, f"{result!r} {told}")
    html = getattr(result, "_repr_html_", None)
    text = repr(result)
    return Shown(html() if html else f"<pre>{escape(text)}</pre>", text)


def _told(value: Any) -> str:
    """Return a value as the notebook's language writes it."""
    if isinstance(value, (float, np.floating)):
        return texts().number(float(f"{value:.4g}"))
    return str(value)
