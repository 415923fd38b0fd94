"""A scene that is inspected: its picture, and what is seen at one pixel after another."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from grader.lab.card import Shown
from grader.lab.engine import marks
from grader.lab.inspector.case import Case, Fault
from grader.lab.inspector.faults import first
from grader.lab.inspector.maps import object_map, wanted
from grader.lab.inspector.nodes import SKY
from grader.lab.inspector.probe import Probe, shape_name
from grader.lab.picture import Picture, black
from grader.lab.scene import Scene
from grader.lab.stopped import Stopped
from grader.lab.vectors import Array
from grader.lab.words import say, texts
from grader.pictures.plan import THINGS, thing
from grader.shapes import Size


@dataclass(frozen=True)
class Seen:
    """What is seen at a pixel: its replay, or what ended it."""

    pixel: tuple[int, int]
    case: Case | None = None
    fault: Fault | None = None
    stopped: Shown | None = None


class Looking:
    """The code of a folder at work on a scene."""

    def __init__(
        self, folder: Path, scene: int | Scene, size: Size, chosen: Mapping[str, Any]
    ) -> None:
        """Set the scene up and draw it. Raises Stopped when the scene cannot be set up."""
        self.folder = folder
        self.probe = Probe(folder, scene, size, chosen)
        self.picture: Picture = black(size)
        self.ended: Shown | None = None  # what ended the drawing of the picture
        self._marks: object = None
        self.refresh()

    def refresh(self) -> bool:
        """Draw the picture again if the files were saved since; return whether they were."""
        found = marks(self.folder)
        if found == self._marks:
            return False
        self._marks, self.ended = found, None
        try:
            self.picture = self.probe.picture()
        except Stopped as error:
            self.ended = error.shown  # the last picture stays
        return True

    def look(self, i: int, j: int) -> Seen:
        """Replay a pixel: column i, row j; what ends the replay is told, not raised."""
        self.refresh()
        width, height = self.probe.size
        i, j = min(max(i, 0), width - 1), min(max(j, 0), height - 1)
        try:
            root = self.probe.replay(i, j)
            drawn = None if self.ended else np.asarray(self.picture[j, i])
            expected = wanted(self.probe.number, self.probe.size, i, j)
            case = Case(self.probe, (i, j), root, expected, drawn)
            return Seen((i, j), case, first(case))
        except Stopped as error:
            if error.by_hand:
                raise
            return Seen((i, j), stopped=error.shown)

    def name(self, index: int) -> str:
        """Return what an object is called."""
        if index == SKY:
            return texts().say("thing.sky.name")
        objects, number = self.probe.scene.objects.data, self.probe.number
        if not 0 <= index < len(objects):
            return say("inspect.unknown")
        if number is not None and number in THINGS and len(THINGS[number]) > 1:
            return texts().say(f"thing.{thing(number, index)}.name")
        return say(f"inspect.shape.{shape_name(int(objects['type'][index]))}", index=index)

    def objects(self) -> Array | None:
        """Return which object stands at each pixel, where the expected maps tell."""
        return object_map(self.probe.number, self.probe.size)
