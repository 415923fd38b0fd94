"""My pictures: what scene 0 looks like after each exercise, small, kept in build/lab/."""

from __future__ import annotations

import base64
import contextlib
from collections.abc import Mapping

from grader.course import exercises
from grader.course.exercises import Exercise
from grader.course.sizes import UNIT
from grader.execution.libraries import Libraries
from grader.execution.library_set import NotBuilt
from grader.execution.records import Limits
from grader.execution.session_socket import Died, MachineError, Missing
from grader.lab.bridge.scene import drawn
from grader.lab.display import store
from grader.lab.display.card import Shown, escape
from grader.lab.display.picture import Picture, encoded, png, tag
from grader.lab.display.words import say

FILE = "pictures.json"
FIRST_TP = 2  # before, no scene is drawn
SCENE = 0
SECONDS = 3.0
_CELL = "display:inline-block;margin:.4em .6em .4em 0"


def keep(exercise: Exercise, libraries: Libraries) -> None:
    """Draw the scene after an exercise that is right, and keep it; what cannot be is left out."""
    if exercise.tp < FIRST_TP or exercise.bonus:
        return
    # A disk that is full, or code that is wrong elsewhere, is told where something is lost by it.
    with contextlib.suppress(OSError, NotBuilt, Died, Missing, MachineError):
        content = encoded(png(_drawn(libraries, exercise.file)))
        store.write(FILE, {**store.read(FILE), exercise.id: content})


def _drawn(libraries: Libraries, file: str) -> Picture:
    with libraries.lend(file).unit(UNIT).session(Limits(cpu=SECONDS)) as session:
        session.call("setup_scene", SCENE)
        return drawn(session, UNIT)


def strip() -> Shown | None:
    """Return the pictures in the course's order; None when there is none yet."""
    kept = store.read(FILE)
    ids = [each.id for each in exercises.load().exercises if each.id in kept]
    figures = [_figure(each, kept) for each in ids]
    if not figures:
        return None
    title = say("album", names=", ".join(ids))
    inside = "".join(figures)
    return Shown(f"<p><b>{escape(say('album_title'))}</b></p><div>{inside}</div>", title)


def _figure(name: str, kept: Mapping[str, object]) -> str:
    try:
        shown = tag(base64.b64decode(str(kept[name]), validate=True), say("album_alt", id=name))
    except ValueError:  # a file that somebody has changed
        return ""
    return f'<figure style="{_CELL}">{shown.html}<figcaption>{escape(name)}</figcaption></figure>'
