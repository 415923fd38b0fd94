"""Makes the scenes from another camera and in other colours, as a seed draws them.

The reference draws them just as a submission is made to: see checking/pictures/other_views.py.
"""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np

from grader.authoring.expected.manifest import put, write_manifest
from grader.authoring.expected.pictures.texels import texels
from grader.build import substitution
from grader.checking.expected_data import Array
from grader.checking.npz import archived
from grader.checking.pictures.other_views import COLORS, FOLDER, OtherView, accepted, settings
from grader.checking.pictures.plan import ExpectedPicture, judged
from grader.checking.student import PICTURE_SIZE, Student
from grader.course import exercises
from grader.course.scenes import load
from grader.course.sizes import sizes_for
from grader.execution.libraries import Libraries
from grader.execution.session import Limits

CACHE = exercises.ROOT / "build" / "cache"
ALL = tuple(sorted({each.scene for each in judged()}))
# The handout's camera looks from (2, 1, 3) at (0, 0.3, 0). It moves towards the x axis: the walls
# of scene 4 stand on the other side.
_POSITION, _AIM, _UP = (2.0, 1.0, 3.0), (0.0, 0.3, 0.0), (0.0, 1.0, 0.0)
_TURNS, _FARTHER, _HIGHER = (0.2, 0.7), (0.9, 1.15), (-0.25, 0.6)  # radians, ratio, scene units
_FIELDS = (50.0, 68.0)  # degrees
_SHADES = (0.1, 0.9)


def store(folder: Path, seed: int, scenes: Collection[int] = ALL) -> None:
    """Write the other views of a folder of expected data."""
    place = folder / FOLDER
    place.mkdir(parents=True, exist_ok=True)
    files: dict[str, Any] = {}
    with Libraries(substitution.reference(), sizes_for(None), CACHE, lazy=True) as libraries:
        student = Student(libraries.lend("raytracer.c"))
        for scene in scenes:
            files |= put(place, dict(_files(student, scene, seed)), {})
    write_manifest(place, {"files": files})


def _files(student: Student, scene: int, seed: int) -> list[tuple[str, bytes]]:
    """Return the files of a scene: how it is laid out, and each stage that is accepted."""
    view = _view(student, scene, np.random.default_rng([seed, scene]))
    arrays = {"camera": view.camera, **view.objects}
    arrays |= {} if view.texels is None else {"texels": view.texels}
    made = [(f"scene{scene}.npz", archived(arrays))]
    for picture in _accepted(scene):
        drawn = student.picture(scene, view.texels, view.begin, **settings(picture))
        assert drawn.shape[:2] == PICTURE_SIZE[::-1]
        levels = np.rint(np.clip(drawn, 0, 1) * 255).astype(np.uint8)
        made.append((f"{picture.name}.npz", archived({"picture": levels})))
    return made


def _accepted(scene: int) -> list[ExpectedPicture]:
    """Return all that is accepted in a scene, once."""
    own = [each for each in judged() if each.scene == scene]
    return list(dict.fromkeys(other for each in own for other in accepted(each)))


def _view(student: Student, scene: int, dice: np.random.Generator) -> OtherView:
    """Draw a camera, and a colour for each object that has one."""
    with student.stage(Limits(cpu=10.0)) as (session, core):
        session.call("setup_scene", scene)
        objects = session.get("scene", int(session.get("object_count")))
        aspect = float(session.get("theCamera")["aspect"])
        where = _moved(dice)
        camera = session.call("init_camera", where, _AIM, _UP, dice.uniform(*_FIELDS), aspect)
        camera_bytes = np.frombuffer(np.asarray(camera.result).tobytes(), np.uint8)
        assert len(camera_bytes) == core.dtype("camera").itemsize
    colors = {name: _colors(objects["mat"][name], dice) for name in COLORS}
    return OtherView(scene, camera_bytes, colors, texels() if load()[scene].patterned else None)


def _moved(dice: np.random.Generator) -> tuple[float, float, float]:
    x, y, z = _POSITION
    turn, farther = dice.uniform(*_TURNS), dice.uniform(*_FARTHER)
    cosine, sine = farther * np.cos(turn), farther * np.sin(turn)
    return x * cosine + z * sine, y + dice.uniform(*_HIGHER), z * cosine - x * sine


def _colors(old: Any, dice: np.random.Generator) -> Array:
    """Return other colours; what has none, as glass, keeps its black."""
    drawn = dice.uniform(*_SHADES, old.shape).astype(np.float32)
    return np.where(old.any(axis=1, keepdims=True), drawn, old)
