"""The parts of a picture: objects, by the light that reaches them; and where a picture is wrong."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from grader.checking.expected_data import Array
from grader.checking.pictures.expected_files import read_arrays
from grader.checking.pictures.measure import Floats
from grader.checking.pictures.plan import STAGES, ExpectedPicture
from grader.checking.shapes import Image, Mask
from grader.course.message import Message
from grader.course.scenes import load

SKY = "sky"
LIT, UNLIT, HIGHLIGHT, SHADOW, WHOLE = "lit", "unlit", "highlight", "shadow", "whole"
BEHIND = -2  # in the maps' `blocker`: the light is behind the surface; -1: it is seen
FEWEST = 12  # pixels of a region
MATCH = 0.02  # share of wrong pixels up to which a region is right


@dataclass(frozen=True)
class Maps:
    """What stands where in a scene; arrays have the shape of the picture, row 0 at the bottom."""

    things: tuple[str, ...]  # names that stand in the picture, sky among them
    thing: Array  # index in `things`
    seen: Array  # what the mirror ray meets: index in `things`
    blocker: Array  # by light, shape (3, height, width)
    highlight: Mask
    bounces: Array  # mirror rays that count, by ks and by Fresnel, shape (2, height, width)
    scene: int

    def of(self, name: str) -> Mask:
        """Return where a thing is seen."""
        if name not in self.things:
            return np.zeros(self.thing.shape, bool)
        where: Mask = self.thing == self.things.index(name)
        return where

    def shade(self) -> tuple[Mask, Array]:
        """Return where something keeps a light off, and the index of what does."""
        first = np.where(self.blocker[0] >= 0, self.blocker[0], self.blocker[1])
        first = np.where(first >= 0, first, self.blocker[2])
        barred: Mask = first >= 0
        return barred, first

    def shadow_of(self, name: str) -> Mask:
        """Return where a thing keeps some light off."""
        where = np.zeros(self.thing.shape, bool)
        for k in np.unique(self.blocker):
            if k >= 0 and load()[self.scene].thing(int(k)) == name:
                where |= (self.blocker == k).any(axis=0)
        return where


@dataclass(frozen=True)
class Region:
    """A part of the picture: a thing where it is lit, in a highlight, in the shadow of another."""

    thing: str
    kind: str
    mask: Mask
    caster: str = ""  # of a shadow

    @property
    def weight(self) -> float:
        """What it counts: small things matter too."""
        return float(np.sqrt(self.mask.sum()))

    @property
    def words(self) -> Message:
        """What it is called."""
        values: dict[str, object] = {"thing": named(self.thing), "caster": of_thing(self.caster)}
        return Message(f"part.{self.kind}", values)


def named(name: str) -> Message:
    """Return the name of a thing: "la sphère rouge"."""
    return Message(f"thing.{name}.name")


def of_thing(name: str) -> Message:
    """Return it after a preposition: "de la sphère rouge"."""
    return Message(f"thing.{name}.of") if name else Message("thing.none.of")


def on_thing(name: str) -> Message:
    """Return the name of a thing with "on": "sur le sol"."""
    return Message(f"thing.{name}.on")


def read_maps(folder: Path, scene: int) -> Maps:
    """Read what stands where in a scene. Raises ExpectedError."""
    arrays = read_arrays(folder, f"scene{scene}.maps.npz")
    most = max(int(arrays[name].max()) for name in ("object", "mirrored", "blocker")) + 1
    names = [load()[scene].thing(k) for k in range(most)]
    order = tuple(dict.fromkeys([SKY, *names]))
    lookup = np.array([*map(order.index, names), 0], np.int16)  # the last for -1, the sky
    shape = arrays["object"].shape
    highlight = np.unpackbits(arrays["highlight"], count=shape[0] * shape[1])
    return Maps(
        things=order,
        thing=lookup[arrays["object"]],
        seen=lookup[arrays["mirrored"]],
        blocker=arrays["blocker"],
        highlight=highlight.reshape(shape).astype(bool),
        bounces=arrays["bounces"],
        scene=scene,
    )


def regions(picture: ExpectedPicture, maps: Maps, calm: Mask) -> list[Region]:
    """Return the regions of a picture that are large enough, without their borders."""
    found = [
        Region(name, kind, mask & calm, caster)
        for name in maps.things
        for kind, caster, mask in _parts(picture, maps, name)
    ]
    return [each for each in found if each.mask.sum() >= FEWEST]


def _parts(picture: ExpectedPicture, maps: Maps, name: str) -> Iterator[tuple[str, str, Mask]]:
    here = maps.of(name)
    on = STAGES[picture.stage]
    if name == SKY or "shading" not in on:
        yield WHOLE, "", here
        return
    unlit = (maps.blocker == BEHIND).all(axis=0)
    yield UNLIT, "", here & unlit
    rest = here & ~unlit
    if "shadows" in on:
        barred, by = maps.shade()
        for k in np.unique(by[rest & barred]):
            yield SHADOW, load()[maps.scene].thing(int(k)), rest & barred & (by == k)
        rest &= ~barred
    yield HIGHLIGHT, "", rest & maps.highlight
    yield LIT, "", rest & ~maps.highlight


def wrong_share(region: Region, wrong: Mask) -> float:
    """Return the share of a region's pixels that are wrong."""
    return float(wrong[region.mask].mean())


def mean_difference(mask: Mask, got: Floats, expected: Floats) -> float:
    """Return by how much the pixels of a mask are too bright (or too dark: below 0)."""
    return float((np.clip(got[mask], 0, 1) - expected[mask]).mean()) if mask.any() else 0.0


@dataclass(frozen=True)
class PictureParts:
    """Everything that is known of a wrong picture; `wrong` is where it counts as wrong."""

    picture: ExpectedPicture
    got: Image
    expected: Image
    wrong: Mask
    calm: Mask
    maps: Maps
    regions: Sequence[Region]
    direct: Image | None = None  # the same without mirrors, when there are some

    def share(self, mask: Mask) -> float:
        """Return the share of the wrong pixels that lie in a mask."""
        total = int(self.wrong.sum())
        return float((self.wrong & mask).sum()) / total if total else 0.0

    def kinds(self, *kinds: str) -> Mask:
        """Return where regions of some kinds are."""
        found = np.zeros(self.wrong.shape, bool)
        for each in self.regions:
            if each.kind in kinds:
                found |= each.mask
        return found

    def brighter(self, mask: Mask) -> float:
        """Return by how much a picture is too bright in a mask, on the mean; 0 to 1."""
        return mean_difference(mask, self.got, self.expected)
