"""From a failed picture to the pixel: what a check shows of the inspector."""

from __future__ import annotations

from grader.lab.card import Shown, code, escape, fold
from grader.lab.inspector import inspect
from grader.lab.inspector.rows import sentence
from grader.lab.stopped import Stopped
from grader.lab.words import say
from grader.pictures.plan import Picture

# Checks of a picture that are not called after its stage.
_STAGES = {"checker": "blinn_phong", "texture": "blinn_phong", "octree": "shadows"}


def picture_of(check: str) -> Picture | None:
    """Return the picture that a check judges, such as that of "tp2.scene.flat_0"; None: no one."""
    _, _, name = check.partition(".scene.")
    if not name:
        return None
    stage, _, scene = name.rpartition("_")
    return Picture(int(scene), _STAGES.get(stage, stage))


def jump(check: str) -> Shown | None:
    """Return the worst pixel of a check's picture and its first wrong value, to be unfolded.

    None for a check that judges no picture, and where the picture cannot be drawn.
    """
    picture = picture_of(check)
    if picture is None:
        return None
    try:
        found = inspect(picture.name)
    except Stopped:
        return None
    i, j = found.seen.pixel
    try:
        lines = [say("inspect.jump", i=i, j=j)]
        lines += [sentence(found.seen.fault)] if found.seen.fault else []
        call = say("inspect.open", name=picture.name, i=i, j=j)
        head = "".join(f"<p>{escape(each)}</p>" for each in lines)
        inside = found.shown().html + code(call)
        html = head + fold(say("inspect.unfold"), inside)
        return Shown(html, "\n".join([*(f"  {each}" for each in lines), f"  {call}"]))
    finally:
        found.looking.probe.close()
