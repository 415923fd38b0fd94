"""live() in a browser: the picture and what is told beside it, and the inspector below."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

from grader.lab.bridge.core import EXPECTED_SIZE
from grader.lab.display.card import stack
from grader.lab.display.picture import Picture, described, encoded, png
from grader.lab.display.scripts import script
from grader.lab.display.stopped import Stopped
from grader.lab.display.words import say
from grader.lab.inspector import inspect
from grader.lab.inspector import widget as inspector
from grader.lab.live.follower import Follower, View

SCRIPT = Path(__file__).with_name("live.js")


@cache
def _kind() -> Any:
    """Return the class of the widget; anywidget is loaded when it is first needed."""
    import anywidget
    import traitlets

    class Widget(anywidget.AnyWidget):
        _esm = script(SCRIPT)
        size = traitlets.List([1, 1]).tag(sync=True)  # of the whole picture, pixels
        help = traitlets.Unicode("").tag(sync=True)  # how to look at a pixel
        picture = traitlets.Unicode("").tag(sync=True)  # base64 of a PNG file; "": none yet
        words = traitlets.Unicode("").tag(sync=True)  # the picture, for who cannot see it
        state = traitlets.Unicode("").tag(sync=True)
        html = traitlets.Unicode("").tag(sync=True)  # what is told beside the picture
        asked: Any = traitlets.List([]).tag(sync=True)  # column, row and a number that grows

    return Widget


class LiveWidget:
    """The widget of one follower. Raises ImportError where anywidget is not installed."""

    def __init__(self, follower: Follower) -> None:
        import ipywidgets  # type: ignore[import-untyped]

        self._follower = follower
        self._live = _kind()(size=list(follower.size), help=say("live.help"))
        self._picture: Picture | None = None  # that is shown
        self._below = ipywidgets.VBox([])
        self._all = ipywidgets.VBox([self._live, self._below])
        self._live.observe(self._inspect, names="asked")

    def bundle(self) -> dict[str, Any]:
        """Return what Jupyter needs to show it."""
        bundle: dict[str, Any] = self._all._repr_mimebundle_()
        return bundle

    def show(self, view: View) -> None:
        """Show a view; from any thread."""
        with self._live.hold_sync():  # one message
            if view.picture is not None and view.picture is not self._picture:
                self._picture = view.picture
                self._live.picture = encoded(png(view.picture))
                self._live.words = described(view.picture)
            self._live.state = view.state
            self._live.html = stack([view.told, view.verdicts]).html

    def _inspect(self, change: Any) -> None:
        """Open the inspector at the pixel that was clicked."""
        import ipywidgets

        follower = self._follower
        # At the size of the expected values.
        i, j = (
            int(at) * most // own
            for at, most, own in zip(change.new, EXPECTED_SIZE, follower.size, strict=False)
        )
        try:
            found = inspect(follower.scene, (i, j), core=follower.core, **follower.chosen)
            shown = inspector.make(found.inspected, found.seen)
        except Stopped as error:
            shown = ipywidgets.HTML(value=error.shown.html)
        before, self._below.children = self._below.children, [shown]
        for each in before:
            each.close()
