"""From a failed picture to the pixel: what a check shows, and the inspector one click away."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from grader.evaluation.records import Pixel
from grader.lab.display.card import Shown, code, escape, fold
from grader.lab.display.stopped import Stopped, display
from grader.lab.display.words import say
from grader.lab.inspector import Inspection, inspect


def pointed(pixel: Pixel) -> Shown:
    """Return a pixel with its first wrong value, and the call that opens the inspector there."""
    call = f'inspect("{pixel.picture}", ({pixel.i}, {pixel.j}))'
    html = f"<p>{escape(pixel.told)}</p>{code(call)}"
    return Shown(html, f"  {pixel.told}\n  {call}")


@dataclass(frozen=True, repr=False)
class Jump(Shown):
    """The inspector at a pixel, folded: a widget, or what a page without widgets unfolds."""

    title: str
    inspection: Inspection

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, Any]:
        """Return what Jupyter chooses from."""
        widget = self.inspection.bundle(self.title)
        return widget | {"text/html": self.html, "text/plain": self.text}


@dataclass(frozen=True, repr=False)
class Checked(Shown):
    """What checks say; below, the inspector at the pixel of each picture that fails."""

    pixels: tuple[Pixel, ...] = ()

    def _ipython_display_(self) -> None:
        """Show it in a cell: the page stays when a notebook is opened again, widgets do not."""
        display(Shown(self.html, self.text))
        for each in self.pixels:
            found = jump(each)
            if found is not None:
                display(found)


def jump(pixel: Pixel) -> Jump | None:
    """Return the inspector at a pixel; None where the scene cannot be set up.

    Its processes end, and start again when another pixel is chosen.
    """
    try:
        found = inspect(pixel.picture, (pixel.i, pixel.j))
    except Stopped:
        return None
    found.inspected.close()
    title = say("inspect.unfold", picture=pixel.picture, i=pixel.i, j=pixel.j)
    return Jump(fold(title, found.shown().html), title, title, found)
