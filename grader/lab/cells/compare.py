"""compare(img, "figure_5"): what is expected, what was drawn, and where they differ."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from PIL import Image

from grader.checking.expected_data import FOLDER, ExpectedError
from grader.checking.pictures import expected_files, image_tools, places
from grader.checking.pictures.measure import Floats, outside
from grader.checking.pictures.places import Place
from grader.checking.pictures.plan import ExpectedPicture
from grader.checking.pictures.regions import read_maps
from grader.checking.pictures.views import BESIDE
from grader.checking.pictures.worst_pixels import worth_a_look
from grader.checking.shapes import Mask
from grader.lab.display.card import Shown, escape
from grader.lab.display.error_cards import sentence
from grader.lab.display.picture import Array, draw, figure, levels, new_figure
from grader.lab.display.plots import ON_DARK
from grader.lab.display.stopped import Stopped
from grader.lab.display.words import say, texts

if TYPE_CHECKING:
    from matplotlib.axes import Axes

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

    Where they differ, the places are told and boxed, and a map shows how alike they are (SSIM).
    `wanted` is a figure of the handout ("figure_4" to "figure_8_right"), an expected picture such
    as "scene4.shadows", or another picture of the same size. Raises Stopped.
    """
    known = plan(wanted) if isinstance(wanted, str) else None
    if isinstance(wanted, str):
        title = title or _title(wanted)
        other = expected(wanted)
    else:
        other = np.asarray(wanted, np.float32)
    if other.shape != img.shape:
        height, width = other.shape[:2]
        raise Stopped(sentence("lab.other_size", width=width, height=height, size=_size(img)))
    ours, theirs = _as_filed(img), _as_filed(other)
    away = np.abs(ours - theirs).max(axis=2)
    share = float((away > SEEN).mean())
    text = say("compared_same") if share == 0 else say("compared", percent=_percent(share))
    caption = say("compared_titled", title=title, text=text) if title else text
    where = _places(ours, away > SEEN, known)
    by_lot = known is not None and known.stage == "glass"
    alike = None if share == 0 or by_lot else image_tools.similarity(ours, theirs)
    shown = _drawn([other, np.asarray(img)], away, where, alike, caption)
    found = places.told(where)
    lines = [texts().say(found.key, **found.values)] if found else []
    lines += [say("compare_similarity")] if alike is not None else []
    told = "".join(f"<p>{escape(line)}</p>" for line in lines)
    return Shown(shown.html + told, "\n".join([shown.text, *lines]))


def _as_filed(picture: Array) -> Floats:
    """Return the colours that a picture's file would have, 0 to 1."""
    return levels(picture)[::-1].astype(np.float32) / np.float32(255)


def _places(ours: Floats, differs: Mask, known: ExpectedPicture | None) -> list[Place]:
    """Return the places that differ; of an expected picture, from all that is accepted."""
    if known is None:
        return places.find(differs)
    try:
        envelope = expected_files.read(FOLDER, known).envelope
        maps = read_maps(FOLDER, known.scene)
    except ExpectedError:
        return places.find(differs)
    return places.find(worth_a_look(outside(ours, envelope), envelope), maps)


def _drawn(
    pictures: list[Array], away: Array, where: list[Place], alike: Array | None, caption: str
) -> Shown:
    """Draw the pictures and their maps, those that there are."""
    columns, rows, inches = (3, 1, (10.5, 2.9)) if alike is None else (2, 2, (10.5, 6.2))
    drawn, axes = new_figure(columns, rows, inches=inches, sharex=True, sharey=True)
    axes = axes.ravel()
    for each, picture, key in zip(axes, pictures, ("expected", "got"), strict=False):
        draw(each, picture, say(f"role.{key}"))
    draw(axes[2], away, say("role.difference"), limits=(0, FULL_SCALE))
    for number, place in enumerate(where[: places.MOST_TOLD], 1):
        _box(axes[2], place, str(number))
    if alike is not None:
        draw(axes[3], alike, say("role.similarity"), limits=(0, 1))
    for each in axes:
        each.label_outer()
    drawn.suptitle(caption, fontsize=10)
    return figure(drawn, f"{say('compare_alt')} {caption}")


def _box(axes: Axes, place: Place, number: str) -> None:
    """Draw a box beside a place, and its number."""
    bottom, left, top, right = np.array(place.box) + BESIDE * np.array((-1, -1, 1, 1)) - 0.5
    left, right = np.clip((left, right), *axes.get_xlim())
    bottom, top = np.clip((bottom, top), *axes.get_ylim())
    corners = ([left, right, right, left, left], [bottom, bottom, top, top, bottom])
    axes.plot(*corners, color=ON_DARK, linewidth=1.2, clip_on=False)
    label = {"boxstyle": "round,pad=0.15", "fc": "white", "ec": "0.4"}
    axes.annotate(number, (left, top), fontsize=8, bbox=label)


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
