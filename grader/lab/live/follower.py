"""A scene that is drawn again whenever a C file is saved: what is to be seen, step by step.

First every STEP-th pixel, by camera_ray and trace_ray; then the picture that raytrace() draws; then
what the checks say of the functions that have changed. One thread uses a Follower from its
beginning to its end: the processes that it starts end with that thread.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np

from grader.checking.shapes import Size
from grader.evaluation.records import Outcome
from grader.files import Marks, marks
from grader.intake import definitions
from grader.lab.bridge.core import Core
from grader.lab.bridge.engine import Engine
from grader.lab.cells import check
from grader.lab.cells.judge import Judge, Judged
from grader.lab.display.card import Shown, card, escape, stack
from grader.lab.display.picture import Picture
from grader.lab.display.stopped import Stopped
from grader.lab.display.words import say

STEP = 8  # pixels between those of the coarse picture
SECONDS, SECONDS_COARSE = 10.0, 2.0  # that the whole picture may take, and the coarse one
WRITING_SECONDS = 0.05  # that an editor takes for one file, at most
NOTHING = Shown("", "")


@dataclass(frozen=True)
class View:
    """What is to be seen at a moment.

    `state` says in a few words how far it is; `told` what has ended the code, and what it printed;
    `verdicts` what the checks say of the functions that have changed.
    """

    picture: Picture | None = None  # None: none was drawn yet
    coarse: bool = False
    state: str = ""
    told: Shown = NOTHING
    verdicts: Shown = NOTHING


@dataclass
class Follower:
    """The code of a folder at work on a scene.

    `chosen` are fields of `options`, as in Core.render.
    """

    folder: Path
    scene: int
    size: Size
    chosen: Mapping[str, Any]
    view: View = field(default_factory=View)

    def __post_init__(self) -> None:
        self._said: list[Shown] = []  # by the code while it runs, and of the files
        engine = Engine(self.folder, apart=True, display=self._said.append)
        self.core, self._judge = Core(engine=engine), Judge()
        self.core.size = self.size
        self.core.options(**self.chosen)
        self._show: Callable[[View], None] = lambda view: None
        self._marks: Marks | None = None
        self._texts: Mapping[str, str] = {}

    def close(self) -> None:
        """End the processes; the next look after a save starts new ones."""
        self.core.close()
        self._judge.close()

    def look(self, show: Callable[[View], None]) -> bool:
        """Draw and judge what was saved since the last look; return whether anything was.

        `show` is given each View.
        """
        self._show = show
        found = marks(self.folder)
        if found == self._marks:
            return False
        while self._marks is not None and found != (later := self._settled()):
            found = later
        self._marks = found
        self._said.clear()
        self._tell(state=say("live.building"), verdicts=NOTHING)
        self._draw()
        # Nothing more can be said of what does not compile, and each check would wait for a loop.
        if not (self.core.engine.errors or self.core.engine.is_endless):
            self._judge_changes()
        return True

    def _settled(self) -> Marks:
        time.sleep(WRITING_SECONDS)
        return marks(self.folder)

    def _tell(self, **parts: Any) -> None:
        self.view = replace(self.view, **parts)
        self._show(self.view)

    def _draw(self) -> None:
        self.core.seconds = SECONDS_COARSE
        try:
            self.core.scene(self.scene)
            self._tell(picture=self._coarse(), coarse=True, state=say("live.coarse", step=STEP))
        except Stopped as error:
            if self.core.engine.is_endless:  # so would the picture be
                self._end(error)
                return
        self.core.seconds = SECONDS
        try:
            picture = self.core.render(self.scene)
        except Stopped as error:
            self._end(error)
        else:
            told, state = stack(self._said), say("live.drawn", time=_now())
            self._tell(picture=picture, coarse=False, state=state, told=told)

    def _end(self, error: Stopped) -> None:
        told = stack([error.shown, *self._said])
        self._tell(state=say("live.ended", time=_now()), told=told)

    def _coarse(self) -> Picture:
        """Return the colours that trace_ray gives at the middle of every STEP-th pixel."""
        across, up = (np.arange(STEP // 2, each, STEP) + 0.5 for each in self.size)
        rays = self.core.camera_ray(*np.meshgrid(across, up))
        return np.asarray(self.core.trace_ray(rays), np.float32).view(Picture)

    def _judge_changes(self) -> None:
        """Check the exercises whose functions are no more what they were when last looked at."""
        files = self.core.engine.files
        texts = {name: content.decode(errors="replace") for name, content in files.items()}
        before, verdicts = self._texts or texts, list[Shown]()
        for each in filter(attrgetter("checks"), definitions.changed(before, texts)):
            if marks(self.folder) != self._marks:
                return  # of the past already: the next look will judge it
            with contextlib.suppress(Stopped):  # the machine's own fault, which check() tells
                verdicts.append(_verdict(self._judge.judge(each)))
            self._tell(verdicts=stack(verdicts))
        self._texts = texts


def _verdict(judged: Judged) -> Shown:
    """Return one line on an exercise, and what is wrong first."""
    wrong = [each for each in check.wrong_checks(judged.checks) if each.message]
    told = [Shown(f"<div>{escape(each.message)}</div>", each.message) for each in wrong[:1]]
    good = judged.result.outcome is Outcome.PASSED
    inside = stack([check.head(judged.result), *told])
    return card(inside.html, inside.text, "good" if good else "plain")


def _now() -> str:
    return time.strftime("%H:%M:%S")
