"""slider(function, epsilon=(0, 0.1)): a picture that follows its parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from grader.lab.display.card import Shown, card, code, escape
from grader.lab.display.picture import Picture, image
from grader.lab.display.stopped import Stopped

STEPS = 100  # of a slider between two numbers that are not both whole
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
        return ipywidgets.VBox([*controls.values(), area]), shown


def slider(function: Callable[..., Any], **ranges: Range | Any) -> Slider:
    """Return sliders for the arguments of a function that returns a picture or what `show` gives.

    A range is (first, last) or (first, last, start): whole numbers when both are; a list of
    choices; or True or False. The slider starts at `start`, or else at the first.
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
        return ipywidgets.SelectionSlider(options=each, value=each[0], **wide)
    first, last = each[:2]
    settings = {"min": first, "max": last, "value": _start(each), **wide}
    if isinstance(first, int) and isinstance(last, int):
        return ipywidgets.IntSlider(**settings)
    step = (last - first) / STEPS
    return ipywidgets.FloatSlider(step=step, readout_format=".4g", **settings)


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
    return f"{value:.4g}" if isinstance(value, (float, np.floating)) else str(value)
