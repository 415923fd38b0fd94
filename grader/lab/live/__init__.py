"""live(): a picture that is drawn again whenever a C file is saved, without running a cell.

    live(0)                          # scene 0, all of it
    live("scene4.shadows")           # an expected picture, or a figure: "figure_6"
    live(5, shadows=False)           # options as in core.render

Beside it stand the compiler's message or the crash, and what the checks say of the functions that
have changed. A click on a pixel opens the inspector there.
"""

from __future__ import annotations

import atexit
import threading
from dataclasses import replace
from typing import Any

from grader.checking.shapes import Size
from grader.lab.bridge.core import DEFAULT_SIZE, Core
from grader.lab.cells import compare
from grader.lab.display.card import Shown, note, stack
from grader.lab.display.links import core_folder
from grader.lab.display.picture import image
from grader.lab.display.words import say
from grader.lab.live.follower import Follower, View

__all__ = ["Live", "live"]

LOOK_SECONDS = 0.1  # between two looks at the files
IDLE_LOOKS = 6000  # without a save, after which no process is kept ready: ten minutes
FIRST_SECONDS = 60.0  # to draw for the first time: the code may loop, and is built before
END_SECONDS = 1.0  # for the thread to end when the kernel does

_last: list[Live] = []


def live(
    scene: int | str = 0, *, core: Core | None = None, size: Size = DEFAULT_SIZE, **chosen: Any
) -> Live:
    """Return a picture that follows the files.

    Parameters
    ----------
    scene : its number, or the name of a picture
    core : whose folder of C files is followed; by default the one the notebooks use
    size : of the picture, pixels
    chosen : fields of `options`, as in core.render

    One follows at a time: the one before stays as it is. Raises Stopped for a name that no picture
    has.
    """
    if isinstance(scene, str):
        options = compare.options(scene)
        scene = int(options.pop("scene"))
        chosen = {**options, **chosen}
    for each in _last:
        each.stop()
    folder = core.engine.folder if core is not None else core_folder()
    _last[:] = [Live(Follower(folder, scene, size, chosen))]
    return _last[0]


class Live:
    """A follower, the thread that it works in, and the widget that shows what it sees."""

    def __init__(self, follower: Follower) -> None:
        self.follower, self.view = follower, View()
        self._widget: Any = None
        self._over, self._drawn = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._follow, name="mrt-live", daemon=True)
        self._thread.start()
        atexit.register(self._end)
        try:
            self._drawn.wait(FIRST_SECONDS)
        except KeyboardInterrupt:
            self.stop()
            raise

    def stop(self) -> None:
        """Follow no more; what is shown stays. A call that runs is not waited for."""
        self._over.set()
        self.show(replace(self.view, state=say("live.over")))

    def _end(self) -> None:
        self._over.set()
        self._thread.join(END_SECONDS)

    def show(self, view: View) -> None:
        """Show a view, where there is a widget."""
        self.view = view
        if self._widget is not None:
            self._widget.show(view)

    def shown(self) -> Shown:
        """Return what a page without a kernel shows."""
        parts = [note(self.view.state), self.view.told, self.view.verdicts]
        if self.view.picture is not None:
            parts.insert(0, image(self.view.picture))
        return stack([each for each in parts if each.text])

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, Any]:
        """Return the widget, and beside it what a page without widgets shows."""
        static = self.shown()
        return {**self._bundle(), "text/html": static.html, "text/plain": static.text}

    def __repr__(self) -> str:
        return self.shown().text

    def _bundle(self) -> dict[str, Any]:
        from grader.lab.live.widget import LiveWidget

        try:
            self._widget = LiveWidget(self.follower)
        except ImportError:  # no anywidget here
            return {}
        self._widget.show(self.view)
        bundle: dict[str, Any] = self._widget.bundle()
        return bundle

    def _follow(self) -> None:
        """Look at the files until it is over; for the thread."""
        idle = 0
        try:
            while not self._over.is_set():
                idle = 0 if self.follower.look(self._tell) else idle + 1
                self._drawn.set()
                if idle == IDLE_LOOKS:
                    self.follower.close()
                self._over.wait(LOOK_SECONDS)
        finally:
            self.follower.close()
            self._drawn.set()

    def _tell(self, view: View) -> None:
        if not self._over.is_set():
            self.show(view)
