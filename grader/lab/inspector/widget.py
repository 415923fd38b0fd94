"""The inspector as a widget: what the browser draws, and the pixels it asks for."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from grader.lab.display.card import stack
from grader.lab.display.picture import encoded, png
from grader.lab.display.scripts import script
from grader.lab.display.vectors import Array
from grader.lab.display.words import say
from grader.lab.inspector import rows, space
from grader.lab.inspector.looking import InspectedScene, Seen

SCRIPT = Path(__file__).with_name("inspector.js")
_LABELS = ("zoom_in", "zoom_out", "space_label")


@cache
def _kind() -> Any:
    """Return the class of the widget; anywidget is loaded when it is first needed."""
    import anywidget
    import traitlets

    class Widget(anywidget.AnyWidget):
        _esm = script(SCRIPT)
        scene = traitlets.Dict().tag(sync=True)  # what a pixel does not change
        seen = traitlets.Dict().tag(sync=True)  # what is seen at the pixel
        pixel = traitlets.List([0, 0]).tag(sync=True)  # column and row, which the browser sets
        fold = traitlets.Unicode("").tag(sync=True)  # what is clicked to unfold it; "": nothing

    return Widget


def bundle(inspected: InspectedScene, seen: Seen, fold: str = "") -> dict[str, Any]:
    """Return what Jupyter needs to show the widget; nothing where anywidget is not installed."""
    try:
        made: dict[str, Any] = make(inspected, seen, fold)._repr_mimebundle_()[0]
    except ImportError:
        return {}
    return made


def make(inspected: InspectedScene, seen: Seen, fold: str = "") -> Any:
    """Return the widget at a pixel; with a title `fold`, it is unfolded by a click on that."""
    widget = _kind()(
        scene=_scene(inspected),
        seen=_seen(inspected, seen),
        pixel=[int(each) for each in seen.pixel],
        fold=fold,
    )

    def follow(change: Any) -> None:
        i, j = change.new
        if inspected.refresh():
            widget.scene = _scene(inspected)
        widget.seen = _seen(inspected, inspected.look(int(i), int(j)))

    widget.observe(follow, names="pixel")
    return widget


def _scene(inspected: InspectedScene) -> dict[str, Any]:
    """Return the picture and the words that go with it."""
    width, height = inspected.probe.size
    objects = inspected.objects()
    names = (
        [inspected.name(k) for k in range(-1, int(objects.max()) + 1)]
        if objects is not None
        else []
    )
    return {
        "picture": encoded(png(inspected.picture)),
        "width": width,
        "height": height,
        "things": encoded(_indices(objects)) if objects is not None else "",
        "names": names,
        "view": space.start_view(inspected),
        "colors": space.COLORS,
        "picture_label": say("inspect.picture_label", width=width, height=height),
        **{name: say(f"inspect.{name}") for name in _LABELS},
    }


def _seen(inspected: InspectedScene, seen: Seen) -> dict[str, Any]:
    """Return the sentences, the table, and what is to be drawn in space."""
    parts = [rows.told(inspected, seen)]
    if inspected.ended is not None and seen.stopped is None:
        parts.insert(0, inspected.ended)
    if seen.case is None:
        return {"pixel": list(seen.pixel), "html": stack(parts).html, "rays": []}
    objects, rays = inspected.probe.content.objects, space.segments(inspected, seen.case.root)
    middle = space.middle(rays)
    spheres, which = space.circles(objects, middle)
    return {
        "pixel": list(seen.pixel),
        "html": stack(parts).html,
        "middle": _numbers(middle),
        "spheres": [
            [*_numbers(each), space.color_of(objects, int(k))]
            for each, k in zip(spheres, which, strict=True)
        ],
        "lines": [_numbers(line) for _, line in space.wires(objects, middle)],
        "rays": [[each.row, each.kind, _numbers(each.start), _numbers(each.end)] for each in rays],
    }


def _indices(objects: Array) -> bytes:
    """Return the index of the object at each pixel as 16 bits, the sky as 0."""
    return (objects + 1).astype("<u2").tobytes()


def _numbers(values: Array) -> Any:
    return np.round(np.asarray(values, np.float64), 4).tolist()
