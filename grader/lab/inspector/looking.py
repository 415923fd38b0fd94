"""A scene that is inspected: its picture, and what is seen at one pixel after another."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from grader.checking.expected_data import FOLDER, ExpectedError, lend_texture
from grader.checking.shapes import Size
from grader.course import scenes
from grader.evaluation.replay.case import ReplayedPixel, WrongValue
from grader.evaluation.replay.expected_maps import object_map, wanted
from grader.evaluation.replay.faults import first
from grader.evaluation.replay.probe import Probe
from grader.evaluation.replay.ray_tree import SKY
from grader.execution.session import Library, Session
from grader.files import marks
from grader.intake.header_numbers import kinds
from grader.lab.bridge.core import Core
from grader.lab.bridge.engine import OpenSession
from grader.lab.bridge.scene import Scene
from grader.lab.display.card import Shown
from grader.lab.display.picture import Picture, black
from grader.lab.display.stopped import Stopped
from grader.lab.display.vectors import Array
from grader.lab.display.words import say, texts

T = TypeVar("T")

SECONDS = 3.0  # of one call: someone waits for the answer


@dataclass(frozen=True)
class Seen:
    """What is seen at a pixel: its replay, or what ended it."""

    pixel: tuple[int, int]
    case: ReplayedPixel | None = None
    fault: WrongValue | None = None
    stopped: Shown | None = None


class _LibraryCaller:
    """The session that stays, with the scene; and with another texture, if one is given."""

    def __init__(self, core: Core, texels: Array | None) -> None:
        self._core, self._texels = core, texels
        self._lent: object = None  # the scene that it was lent to

    def ask(self, name: str, act: Callable[[Session, Library], T]) -> T:
        """Let `act` use the session. Raises Stopped."""

        def lent(stage: OpenSession) -> T:
            if self._texels is not None and stage.placed is not self._lent:
                lend_texture(stage.session, stage.core, self._texels)
                self._lent = stage.placed
            return act(stage.session, stage.core)

        return self._core.use(name, lent)


class InspectedScene:
    """The code of a folder at work on a scene."""

    def __init__(
        self,
        folder: Path,
        scene: int | Scene,
        size: Size,
        chosen: Mapping[str, Any],
        texels: Array | None = None,
    ) -> None:
        """Set the scene up and draw it. Raises Stopped when the scene cannot be set up.

        `chosen` are fields of `options`; `texels` take the place of the scene's texture.
        """
        self.folder, self._chosen = folder, dict(chosen)
        self.has_texture = texels is not None  # that of the expected pictures
        self._core = Core(folder)
        self._core.size, self._core.seconds = size, SECONDS
        self._core.options(**chosen)
        if isinstance(scene, Scene):
            self._core.set_scene(scene.objects, scene.lights, scene.camera)
        else:
            self._core.scene(scene)
        number = scene if isinstance(scene, int) else None
        self.probe = Probe(_LibraryCaller(self._core, texels), size, number)
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
            self.probe.call("sky_color")  # sets the scene up, with its texture
            self.picture = self._core.render(**self._chosen)
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
            expected = wanted(FOLDER, self.probe.number, self.probe.size, i, j)
            case = ReplayedPixel(self.probe, (i, j), root, expected, drawn, FOLDER)
            return Seen((i, j), case, _first(case))
        except Stopped as error:
            if error.by_hand:
                raise
            return Seen((i, j), stopped=error.shown)

    def close(self) -> None:
        """End the processes; the next look starts new ones."""
        self._core.close()

    def name(self, index: int) -> str:
        """Return what an object is called."""
        if index == SKY:
            return texts().say("thing.sky.name")
        objects, number = self.probe.content.objects, self.probe.number
        if not 0 <= index < len(objects):
            return say("inspect.unknown")
        rules = None if number is None else scenes.load().get(number)
        if rules and len(rules.things) > 1:
            return texts().say(f"thing.{rules.thing(index)}.name")
        kind = kinds()[int(objects["type"][index])].lower()
        return say(f"inspect.shape.{kind}", index=index)

    def objects(self) -> Array | None:
        """Return which object stands at each pixel, where the expected maps tell."""
        return object_map(FOLDER, self.probe.number, self.probe.size)


def _first(case: ReplayedPixel) -> WrongValue | None:
    """Return the first wrong value; None too where the expected data is not whole."""
    try:
        return first(case)
    except ExpectedError:
        return None
