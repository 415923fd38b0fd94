"""The pixel inspector: why is this pixel this colour.

    inspect(0)                              # scene 0, at the pixel that is most wrong
    inspect(0, (150, 70), shadows=False)    # column 150, row 70; options as in core.render
    inspect("scene4.shadows")               # an expected picture, or a figure: "figure_6"

The pixel is replayed: the functions are called one by one along its ray. Each value that they give
stands in a table; the first that goes wrong is named.
"""

from __future__ import annotations

from typing import Any

from grader.checking.expected_data import FOLDER, ExpectedError
from grader.checking.pictures import expected_files
from grader.checking.pictures.plan import ExpectedPicture, everything
from grader.checking.pictures.worst_pixels import worst_pixel
from grader.checking.shapes import Size
from grader.lab.bridge.core import EXPECTED_SIZE, Core
from grader.lab.bridge.scene import Scene
from grader.lab.cells import compare
from grader.lab.display.card import Shown, note, stack
from grader.lab.display.error_cards import sentence
from grader.lab.display.links import core_folder
from grader.lab.display.stopped import Stopped
from grader.lab.display.vectors import Array
from grader.lab.display.words import say
from grader.lab.inspector import rows, space
from grader.lab.inspector.looking import InspectedScene, Seen

__all__ = ["Inspection", "inspect", "shown"]

FULL = "fresnel"  # the stage whose options are those at the start


def inspect(
    scene: int | str | Scene = 0,
    pixel: tuple[int, int] | None = None,
    *,
    core: Core | None = None,
    size: Size = EXPECTED_SIZE,
    **chosen: Any,
) -> Inspection:
    """Return the inspector of a scene, opened at a pixel (column, row).

    Parameters
    ----------
    scene : its number, a scene of your own (core.scene()), or the name of a picture
    pixel : column and row; by default the pixel that is most wrong, or else the middle
    core : whose folder of C files is looked at; by default the one the notebooks use
    size : of the picture, pixels; expected values exist at 320 x 180
    chosen : fields of `options`, as in core.render

    Raises Stopped.
    """
    folder = core.engine.folder if core is not None else core_folder()
    picture = ExpectedPicture(scene, FULL) if isinstance(scene, int) and not chosen else None
    texels = None
    if isinstance(scene, str):
        picture = compare.plan(scene)
        options = compare.options(scene)
        scene = int(options.pop("scene"))
        chosen = {**options, **chosen}
        texels = _texels(picture)
    inspected = InspectedScene(folder, scene, size, chosen, texels)
    if pixel is None:
        pixel = _start(inspected, picture)
    elif len(pixel) != 2:
        raise Stopped(sentence("lab.inspect.no_pixel", scene=scene))
    return Inspection(inspected, inspected.look(int(pixel[0]), int(pixel[1])))


class Inspection:
    """An inspector in a cell: a widget, or a picture and a table where there is no widget."""

    def __init__(self, inspected: InspectedScene, seen: Seen) -> None:
        self.inspected, self.seen = inspected, seen

    def at(self, i: int, j: int) -> Inspection:
        """Look at another pixel: column i, row j."""
        self.seen = self.inspected.look(i, j)
        return self

    def shown(self) -> Shown:
        """Return the static page: sentences, table and picture."""
        return shown(self.inspected, self.seen)

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, Any]:
        """Return the widget, and beside it what a page without widgets shows."""
        static = self.shown()
        return {**self.bundle(), "text/html": static.html, "text/plain": static.text}

    def bundle(self, fold: str = "") -> dict[str, Any]:
        """Return what Jupyter needs to show the widget; `fold` is the title that unfolds it."""
        from grader.lab.inspector.widget import bundle

        return bundle(self.inspected, self.seen, fold)

    def __repr__(self) -> str:
        return rows.told(self.inspected, self.seen).text


def shown(inspected: InspectedScene, seen: Seen) -> Shown:
    """Return a pixel as a static page."""
    parts = [rows.told(inspected, seen), space.static(inspected, seen)]
    if inspected.ended is not None:
        head = note(say("inspect.not_drawn"), "bad")
        parts = [head, *([inspected.ended] if seen.stopped is None else []), *parts]
    return stack(parts)


def _texels(picture: ExpectedPicture) -> Array | None:
    """Return the texture that an expected picture was drawn with, if it has one of its own."""
    try:
        return expected_files.read_texels(FOLDER) if picture.rules.patterned else None
    except ExpectedError:
        return None


def _start(inspected: InspectedScene, picture: ExpectedPicture | None) -> tuple[int, int]:
    """Return the pixel that is most wrong, if that can be told, or else the middle."""
    width, height = inspected.probe.size
    middle = width // 2, height // 2
    if picture is None or (width, height) != EXPECTED_SIZE or inspected.ended:
        return middle
    if picture not in everything():
        return middle
    if picture.rules.patterned and not inspected.has_texture:
        return middle
    try:
        return worst_pixel(FOLDER, picture, inspected.picture) or middle
    except ExpectedError:
        return middle
