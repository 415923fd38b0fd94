"""Pictures that are wrong in a way that is known, and what must be said of each.

What a student may do wrong is drawn by the reference with a change; what is wrong with a picture as
a whole is done to the reference's own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any

import numpy as np

from grader.authoring.expected.pictures.make import maps
from grader.authoring.expected.pictures.sources import (
    PictureSource,
    by_change,
    by_files,
    by_mistake,
)
from grader.authoring.specimens import mistakes
from grader.authoring.specimens.patches import reference
from grader.checking.expected_data import FOLDER
from grader.checking.pictures.judgement import Judgement, judge
from grader.checking.pictures.plan import ExpectedPicture
from grader.checking.shapes import Image
from grader.course.message import Message

Change = Callable[[Image], Image]

_IN_LIST = "if (intersect_object(r, it, &scene[k])) {"
_SHADOW = "return nearest_hit(&r, &unused);"
_TO_LIGHT = "vector_minus(lights[k].position, it->position)"
# Changes of raytracer.c: what stands there, and what stands there instead.
_CHANGES: Mapping[str, tuple[str, str]] = {
    "red sphere missing": (_IN_LIST, f"if (k != 1 && {_IN_LIST[4:]}"),
    "cylinder missing": (_IN_LIST, f"if (k != 6 && {_IN_LIST[4:]}"),
    "red shadow missing": (
        _SHADOW,
        _SHADOW[:-1] + " && memcmp(&unused.mat, &scene[1].mat, sizeof unused.mat) != 0;",
    ),
    "light moved by a tenth": (
        _TO_LIGHT,
        "vector_minus(vector_float_mul(1.1f, lights[k].position), it->position)",
    ),
    "depth 1": ("r->depth > options.max_depth", "r->depth > 1"),
    "shininess doubled": ("powf(h_n, mat->shininess)", "powf(h_n, 2 * mat->shininess)"),
    "ambient light": (
        "    color sum = vector_init(0.f, 0.f, 0.f);\n    /* END SOLUTION */",
        "    color sum = vector_float_mul(0.1f, it->mat.kd);\n    /* END SOLUTION */",
    ),
}
_SETTINGS: Mapping[str, dict[str, Any]] = {
    "acne": {"epsilon": 3e-7},
    "no shadow": {"shadows": 0},
    "no reflection": {"reflections": 0},
    "no Fresnel": {"fresnel": 0},
    "no samples": {"samples": 1},
}
_OBJECT, _SKY = 3, np.array([0.2, 0.2, 0.6], np.float32)


@dataclass(frozen=True)
class WrongProgram:
    """A wrong picture, and what must be said of it."""

    id: str
    scene: int
    stage: str
    key: str  # of the sentence, without "picture."
    thing: str = ""  # that the sentence names, or the part of one
    worth: tuple[float, float] = (0.0, 0.9)  # what it may earn, as a share of the points

    @property
    def picture(self) -> ExpectedPicture:
        """What it is meant to be."""
        return ExpectedPicture(self.scene, self.stage)

    def drawn(self) -> Image:
        """Draw it."""
        if change := _whole(self.scene).get(self.id):
            return np.ascontiguousarray(change(_source("").draw(self.picture).copy()))
        return _source(self.id).draw(self.picture)

    def judged(self) -> Judgement:
        """Draw and judge it."""
        return judge(FOLDER, self.picture, self.drawn())

    def complaint(self, found: Judgement) -> str:
        """Return what is said of it that should not be, or "" when all is as it must be."""
        key = found.complaint.key if found.complaint else "nothing"
        if key != f"picture.{self.key}":
            return f"{key} for picture.{self.key}"
        if self.thing not in things(found):
            return f"{key} names {things(found)}, not {self.thing}"
        least, most = self.worth
        return "" if least <= found.share <= most else f"{key} earns {found.share:.2f}"


def things(found: Judgement) -> list[str]:
    """Return the things and parts that a complaint names, and "" besides."""
    return ["", *_things(found.complaint)] if found.complaint else [""]


def _things(verdict: Message) -> Iterator[str]:
    start, _, name = verdict.key.partition(".")
    if start in ("thing", "part"):
        yield name.partition(".")[0]
    for value in verdict.values.values():
        if isinstance(value, Message):
            yield from _things(value)


@cache
def _source(name: str) -> PictureSource:
    if change := _CHANGES.get(name):
        return by_change(name, *change)
    for mistake in mistakes.load():
        if mistake.id == name:
            return by_mistake(mistake)
    return replace(by_files("reference", reference()), settings=_SETTINGS.get(name, {}))


def _whole(scene: int) -> Mapping[str, Change]:
    """Return what is done to the reference's own picture."""
    shown = maps(scene)["object"]
    return {
        "all black": np.zeros_like,
        "all grey": lambda image: np.full_like(image, 0.5),
        "all sky": lambda image: np.broadcast_to(_SKY, image.shape).astype(np.float32),
        "all NaN": lambda image: np.full_like(image, np.nan),
        "one NaN": partial(_put, where=(slice(20, 21), slice(30, 31)), color=np.nan),
        "upside down": np.flipud,
        "mirrored": np.fliplr,
        "half a turn": partial(np.flip, axis=(0, 1)),
        "red and blue swapped": partial(np.take, indices=(2, 1, 0), axis=2),
        "channels turned": partial(np.roll, shift=1, axis=2),
        "too bright": lambda image: np.where((shown >= 0)[:, :, None], 3.1 * image, image),
        "too dark": lambda image: np.where((shown >= 0)[:, :, None], image / 2, image),
        "gamma": lambda image: np.clip(image, 0, None) ** np.float32(1 / 2.2),
        "one pixel off": partial(np.roll, shift=1, axis=1),
        "recoloured": partial(_put, where=shown == _OBJECT, color=(0.9, 0.9, 0.1)),
        "wrong sky": partial(_put, where=shown < 0, color=(0.4, 0.6, 1.0)),
    }


def _put(image: Image, where: Any, color: Any) -> Image:
    image[where] = color
    return image


_NOTHING = (0.0, 0.0)
TABLE = (
    *(
        WrongProgram(name, scene, stage, key, worth=_NOTHING)
        for scene, stage in ((0, "flat"), (4, "shadows"), (0, "smooth"))
        for name, key in (("all black", "black"), ("all grey", "one_color"))
    ),
    WrongProgram("all sky", 0, "flat", "one_color", worth=_NOTHING),
    WrongProgram("all NaN", 0, "flat", "not_finite", worth=_NOTHING),
    WrongProgram("one NaN", 4, "fresnel", "not_finite", worth=_NOTHING),
    *(
        WrongProgram(name, scene, stage, key, worth=(0.0, 0.6))
        for scene, stage in ((0, "flat"), (4, "shadows"), (1, "fresnel"))
        for name, key in (
            ("upside down", "upside_down"),
            ("mirrored", "mirrored"),
            ("half a turn", "half_turn"),
            ("red and blue swapped", "channels_rb"),
            ("channels turned", "channels_turned"),
        )
    ),
    WrongProgram("too bright", 4, "blinn_phong", "all_bright"),
    WrongProgram("too dark", 0, "shadows", "all_dark"),
    WrongProgram("gamma", 4, "shadows", "gamma_applied"),
    WrongProgram("one pixel off", 0, "flat", "shifted_right"),
    WrongProgram("recoloured", 0, "flat", "recolored", "sphere_blue", (0.6, 0.9)),
    WrongProgram("wrong sky", 0, "flat", "sky", "sky", (0.5, 0.9)),
    WrongProgram("red sphere missing", 0, "flat", "missing", "sphere_red", (0.6, 0.9)),
    WrongProgram("red sphere missing", 0, "shadows", "missing", "sphere_red", (0.2, 0.9)),
    WrongProgram("red sphere missing", 4, "flat", "missing", "sphere_red", (0.6, 0.9)),
    WrongProgram("cylinder missing", 2, "flat", "missing", "cylinder_up", (0.6, 0.9)),
    WrongProgram("light moved by a tenth", 4, "blinn_phong", "light_moved", worth=(0.0, 0.6)),
    WrongProgram("light moved by a tenth", 4, "shadows", "light_moved", worth=(0.0, 0.6)),
    WrongProgram("acne", 0, "shadows", "acne", "floor"),
    WrongProgram("acne", 4, "shadows", "acne"),
    *(WrongProgram("no shadow", scene, "shadows", "without", worth=_NOTHING) for scene in (0, 4)),
    *(
        WrongProgram("no reflection", scene, "mirror", "without", worth=_NOTHING)
        for scene in (0, 4)
    ),
    *(WrongProgram("no Fresnel", scene, "fresnel", "without", worth=_NOTHING) for scene in (0, 4)),
    *(WrongProgram("no samples", scene, "smooth", "without", worth=_NOTHING) for scene in (0, 4)),
    WrongProgram("red shadow missing", 0, "shadows", "shadow_missing", "sphere_red", (0.3, 0.9)),
    WrongProgram("depth 1", 4, "mirror", "bounces"),
    WrongProgram("depth 1", 1, "fresnel", "bounces"),
    WrongProgram("shininess doubled", 0, "blinn_phong", "part_dark", "highlight"),
    WrongProgram("ambient light", 0, "shadows", "unlit_bright"),
    WrongProgram("shadow_acne", 0, "shadows", "all_shadow"),
    WrongProgram("shadow_beyond_light", 4, "shadows", "shadow_extra"),
    WrongProgram("shade_pi_forgotten", 0, "blinn_phong", "all_bright"),
    WrongProgram("shade_h_halved", 0, "blinn_phong", "part_dark", "highlight"),
    WrongProgram("mirror_single_bounce", 1, "mirror", "bounces"),
    WrongProgram("mirror_without_k", 0, "mirror", "mirror_bright"),
    WrongProgram("camera_fov_ignored", 0, "flat", "placed"),
    WrongProgram("samples_all_at_centre", 4, "smooth", "without"),
    WrongProgram("samples_outside_pixel", 0, "smooth", "jagged"),
    WrongProgram("samples_neighbours_blurred", 4, "smooth", "jagged"),
)
