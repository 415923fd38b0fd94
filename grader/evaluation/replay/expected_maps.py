"""What the reference gives at the first hit of a pixel, where there are expected maps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from grader.checking.expected_data import Array, ExpectedError
from grader.checking.pictures import expected_files
from grader.checking.shapes import Size
from grader.checking.student import PICTURE_SIZE
from grader.course.scenes import load
from grader.evaluation.replay.ray_tree import SKY

_NORMAL_UNITS, _COSINE_UNITS = 32767, 127
NO_BLOCKER, _BEHIND = -1, -2  # in `blocker`: the light is seen, or behind the surface
_AROUND = ((0, 0), (0, -1), (0, 1), (-1, 0), (1, 0), (-1, -1), (-1, 1), (1, -1), (1, 1))
_COLORS = ("kd", "fresnel", "plain", "low")


@dataclass(frozen=True)
class Wanted:
    """The values at a pixel and its eight neighbours, the pixel's own first.

    At an edge rounding decides which of two objects a ray meets: what stands right beside is as
    good. Arrays have the neighbours as their first axis.
    """

    object: Array
    t: Array
    normal: Array
    kd: Array
    fresnel: Array
    n_l: Array  # shape (count, lights)
    blocker: Array  # shape (count, lights)
    plain: Array  # what shade gives with ks in the lobe, shape (count, lights, 3)
    low: Array  # with Fresnel, the least and the most that is accepted
    high: Array
    mirrored: Array
    bounces: Array  # mirror rays that count: by ks, by Fresnel

    def meets(self, index: int) -> bool:
        """Return whether an object (or SKY) may be met there."""
        return index in self.object

    def of(self, index: int) -> Array:
        """Return which of the neighbours see that object: a mask."""
        seen: Array = self.object == index
        return seen

    def may_be_seen(self, light: int) -> bool:
        """Return whether a light reaches the point, or that of a neighbour."""
        return bool((self.blocker[:, light] == NO_BLOCKER).any())

    def may_be_hidden(self, light: int) -> bool:
        """Return whether something stands before a light, or does for a neighbour."""
        return bool((self.blocker[:, light] != NO_BLOCKER).any())

    def is_behind(self, light: int) -> bool:
        """Return whether a light is behind the surface, or may be."""
        return bool((self.blocker[:, light] == _BEHIND).any())


@lru_cache(maxsize=4)
def _stored(folder: Path, scene: int) -> Mapping[str, Array] | None:
    """Return the maps of a scene, as they are stored; None when there are none."""
    try:
        maps = expected_files.read_arrays(folder, f"scene{scene}.maps.npz")
        return {**maps, **expected_files.read_arrays(folder, f"scene{scene}.light.npz")}
    except ExpectedError:
        return None


def wanted(folder: Path, scene: int | None, size: Size, i: int, j: int) -> Wanted | None:
    """Return what is expected around a pixel; None where no map tells.

    `folder` is that of the expected data.
    """
    arrays = _of(folder, scene, size)
    if arrays is None:
        return None
    width, height = size
    places = [(j + y, i + x) for y, x in _AROUND if 0 <= j + y < height and 0 <= i + x < width]
    rows, columns = np.array(places).T
    low = int(rows.min())
    unpacked = _rows(arrays, low, int(rows.max()) + 1)
    return Wanted(
        **{
            name: np.moveaxis(each[..., rows - low, columns], -1, 0)
            for name, each in unpacked.items()
        }
    )


def object_map(folder: Path, scene: int | None, size: Size) -> Array | None:
    """Return which object is seen at each pixel, by the reference; None where no map tells."""
    arrays = _of(folder, scene, size)
    return None if arrays is None else np.maximum(arrays["object"], SKY)


def _of(folder: Path, scene: int | None, size: Size) -> Mapping[str, Array] | None:
    known = scene is not None and scene in load() and size == PICTURE_SIZE
    return _stored(folder, scene) if known and scene is not None else None


def _rows(arrays: Mapping[str, Array], first: int, end: int) -> dict[str, Array]:
    """Return some rows of the maps, unpacked: the last axes are rows and columns."""
    cut = {
        name: each[..., first:end, :]
        for name, each in arrays.items()
        if name not in ("normal", "highlight")
    }
    colors = {name: expected_files.colors(cut[name]) for name in _COLORS}
    normal = np.moveaxis(arrays["normal"][first:end], -1, 0)
    return {
        **colors,
        "high": colors["low"] + expected_files.colors(cut["range"]),
        "t": expected_files.distances(cut["t"]),
        "normal": normal / np.float32(_NORMAL_UNITS),
        "n_l": cut["n_l"] / np.float32(_COSINE_UNITS),
        **{name: cut[name] for name in ("object", "mirrored", "blocker", "bounces")},
    }
