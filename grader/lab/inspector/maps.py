"""What the reference gives at the first hit of a pixel, where there are expected maps."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from grader.expected import FOLDER, ExpectedError
from grader.judge import PICTURE_SIZE
from grader.lab.inspector.nodes import SKY
from grader.lab.vectors import Array
from grader.pictures import stored
from grader.pictures.plan import SCENES

_NORMAL_UNITS, _COSINE_UNITS = 32767, 127
_BEHIND, _SEEN = -2, -1  # in `blocker`
_AROUND = ((0, 0), (0, -1), (0, 1), (-1, 0), (1, 0), (-1, -1), (-1, 1), (1, -1), (1, 1))


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
        return bool((self.blocker[:, light] == _SEEN).any())

    def may_be_hidden(self, light: int) -> bool:
        """Return whether something stands before a light, or does for a neighbour."""
        return bool((self.blocker[:, light] != _SEEN).any())

    def is_behind(self, light: int) -> bool:
        """Return whether a light is behind the surface, or may be."""
        return bool((self.blocker[:, light] == _BEHIND).any())


@lru_cache(maxsize=2)
def _arrays(scene: int) -> dict[str, Array] | None:
    """Return the maps of a scene, as they are stored but unpacked; None when there are none."""
    if scene not in SCENES:
        return None
    try:
        maps = stored.read_arrays(FOLDER, f"scene{scene}.maps.npz")
        light = stored.read_arrays(FOLDER, f"scene{scene}.light.npz")
    except ExpectedError:
        return None
    colors = {name: stored.colors(light[name]) for name in ("kd", "fresnel", "plain", "low")}
    return {
        **colors,
        "high": colors["low"] + stored.colors(light["range"]),
        "object": maps["object"],
        "mirrored": maps["mirrored"],
        "t": stored.distances(maps["t"]),
        "normal": np.moveaxis(maps["normal"], -1, 0) / np.float32(_NORMAL_UNITS),
        "blocker": maps["blocker"],
        "n_l": light["n_l"] / np.float32(_COSINE_UNITS),
        "bounces": maps["bounces"],
    }


def wanted(scene: int | None, size: tuple[int, int], i: int, j: int) -> Wanted | None:
    """Return what is expected around a pixel; None where no map tells."""
    arrays = _arrays(scene) if scene is not None and size == PICTURE_SIZE else None
    if arrays is None:
        return None
    width, height = size
    places = [(j + y, i + x) for y, x in _AROUND if 0 <= j + y < height and 0 <= i + x < width]
    rows, columns = np.array(places).T
    return Wanted(
        **{name: np.moveaxis(each[..., rows, columns], -1, 0) for name, each in arrays.items()}
    )


def object_map(scene: int | None, size: tuple[int, int]) -> Array | None:
    """Return which object is seen at each pixel, by the reference; None where no map tells."""
    arrays = _arrays(scene) if scene is not None and size == PICTURE_SIZE else None
    return None if arrays is None else np.maximum(arrays["object"], SKY)
