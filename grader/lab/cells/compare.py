"""compare(img, "figure_5"): what is expected, what was drawn, and where they differ."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from grader.checking.expected_data import FOLDER
from grader.checking.pictures.plan import ExpectedPicture
from grader.lab.display.card import Shown
from grader.lab.display.error_cards import sentence
from grader.lab.display.picture import Array, draw, figure, levels, new_figure
from grader.lab.display.stopped import Stopped
from grader.lab.display.words import say, texts

# The handout's figures; those of scenes are among the expected pictures.
FIGURES: Mapping[str, ExpectedPicture] = {
    "figure_4": ExpectedPicture(0, "flat"),
    "figure_5": ExpectedPicture(0, "blinn_phong"),
    "figure_6": ExpectedPicture(0, "shadows"),
    "figure_7_left": ExpectedPicture(0, "mirror"),
    "figure_7": ExpectedPicture(0, "fresnel"),
    "figure_8": ExpectedPicture(0, "smooth"),
    "figure_8_right": ExpectedPicture(4, "smooth"),
}
PICTURES = FOLDER / "pictures"
FULL_SCALE = 0.25  # of the difference: the same for every picture, so that two can be compared
SEEN = 3 / 255  # below, nobody sees a difference


def plan(name: str) -> ExpectedPicture:
    """Return which scene and options a figure, or "scene4.shadows", is. Raises Stopped."""
    if name in FIGURES:
        return FIGURES[name]
    try:
        return ExpectedPicture.parse(name)
    except (ValueError, KeyError):
        raise Stopped(sentence("lab.no_figure", name=name, known=", ".join(FIGURES))) from None


def expected(name: str) -> Array:
    """Return an expected picture, shape (180, 320, 3), row 0 at the bottom. Raises Stopped."""
    path = _file(plan(name).name)
    try:
        with Image.open(path) as file:
            return np.asarray(file.convert("RGB"), np.float32)[::-1] / 255
    except OSError as error:
        raise Stopped(sentence("lab.no_expected", name=path.name, error=error)) from None


def compare(img: Array, wanted: str | Array, title: str = "") -> Shown:
    """Return the expected picture, yours, and their difference on a fixed scale.

    `wanted` is a figure of the handout ("figure_4" to "figure_8_right"), an expected picture such
    as "scene4.shadows", or another picture of the same size. Raises Stopped.
    """
    if isinstance(wanted, str):
        title = title or _title(wanted)
        other = expected(wanted)
    else:
        other = np.asarray(wanted, np.float32)
    if other.shape != img.shape:
        height, width = other.shape[:2]
        raise Stopped(sentence("lab.other_size", width=width, height=height, size=_size(img)))
    ours = levels(img)[::-1].astype(np.float32) / 255
    theirs = levels(other)[::-1].astype(np.float32) / 255
    away = np.abs(ours - theirs).max(axis=2)
    share = float((away > SEEN).mean())
    text = say("compared_same") if share == 0 else say("compared", percent=_percent(share))
    caption = say("compared_titled", title=title, text=text) if title else text
    return _drawn([other, np.asarray(img)], away, caption)


def _drawn(pictures: list[Array], away: Array, caption: str) -> Shown:
    drawn, axes = new_figure(3, 1, inches=(10.5, 2.9), sharex=True, sharey=True)
    for each, picture, key in zip(axes, pictures, ("expected", "got"), strict=False):
        draw(each, picture, say(f"role.{key}"))
    draw(axes[2], away, say("role.difference"), limits=(0, FULL_SCALE))
    for each in axes:
        each.label_outer()
    drawn.suptitle(caption, fontsize=10)
    return figure(drawn, f"{say('compare_alt')} {caption}")


def _title(name: str) -> str:
    """Return a figure's name in words: "figure 7, left" for "figure_7_left"."""
    base, _, side = name.rpartition("_")
    key = {"left": "figure_left", "right": "figure_right"}.get(side)
    return say(key, name=base.replace("_", " ")) if key else name.replace("_", " ")


def _percent(share: float) -> str:
    return texts().number(float(f"{100 * share:.{3 if share >= 0.1 else 2}g}"))


def _size(img: Array) -> str:
    return " x ".join(str(each) for each in img.shape[1::-1])


def _file(name: str) -> Path:
    return PICTURES / f"{name}.png"


def options(name: str) -> dict[str, Any]:
    """Return the scene and the options of a figure, as core.render takes them."""
    chosen = plan(name)
    switches = {key: bool(value) for key, value in chosen.options.items() if key != "samples"}
    return {"scene": chosen.scene, **switches, "samples": chosen.options["samples"]}
