"""What is wrong, and who is at fault, when a ray does not meet what it should."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from grader.checking.expected_data import Array
from grader.evaluation.replay.case import FAR_T, ReplayedPixel, WrongValue, far, told
from grader.evaluation.replay.ray_tree import Alone, RayHit
from grader.intake.header_numbers import kinds

_OFF = 1e-2  # scene units: a point that is farther from a surface does not lie on it


def astray(
    case: ReplayedPixel, ray: Any, alone: tuple[Alone, ...], depth: int
) -> Iterator[WrongValue]:
    """Hold what each object says of a ray against the ray, and against the object itself."""
    for each in alone:
        if each.spoilt:
            yield WrongValue("miss", case.shape(each.index), depth)
        elif each.hit is not None and _astray(case, ray, each.index, each.hit):
            yield false_hit(case, ray, each.index, depth)


def false_hit(case: ReplayedPixel, ray: Any, index: int, depth: int = 0) -> WrongValue:
    """Say what is wrong with a hit that is not where the object is: t, or that there is one."""
    distances = _distances(case, ray, index)
    if distances is None:
        return WrongValue("elsewhere", case.shape(index), depth)
    if distances.size:
        return WrongValue("t", case.shape(index), depth, wanted=told(distances[0]))
    return WrongValue("met", case.shape(index), depth)


def _distances(case: ReplayedPixel, ray: Any, index: int) -> Array | None:
    """Return where a ray meets a sphere or a plane, nearest first; None of another object."""
    each = case.probe.content.objects[index]
    kind = kinds()[int(each["type"])]
    orig, direction = ray["orig"].astype(np.float64), ray["dir"].astype(np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):  # of a ray that leads nowhere
        if kind == "SPHERE":
            away = orig - each["center"]
            square, half = direction @ direction, away @ direction
            root = np.emath.sqrt(half**2 - square * (away @ away - float(each["radius"]) ** 2))
            found = (np.array([-root, root]) - half) / square
        elif kind == "PLANE":
            up = direction @ each["normal"]
            found = np.array([-(orig @ each["normal"] + each["dist"]) / up])
        else:
            return None
    real = found.real[(found.imag == 0) & np.isfinite(found)]
    distances: Array = real[(real >= ray["tmin"]) & (real <= ray["tmax"])]
    return distances


def _astray(case: ReplayedPixel, ray: Any, index: int, hit: RayHit) -> bool:
    """Return whether a hit is out of the ray's range, or not on its sphere or plane."""
    if not ray["tmin"] <= hit.t <= ray["tmax"]:
        return True
    each, point = case.probe.content.objects[index], ray["orig"] + hit.t * ray["dir"]
    kind = kinds()[int(each["type"])]
    if kind == "SPHERE":
        away = np.linalg.norm(point - each["center"]) - each["radius"]
    elif kind == "PLANE":
        away = point @ each["normal"] + each["dist"]
    else:
        return False
    return not abs(away) <= _OFF * (1 + np.abs(point).max())


def nearest(alone: tuple[Alone, ...]) -> RayHit | None:
    """Return the nearest of the hits that objects give when they are asked alone."""
    hits = [each.hit for each in alone if each.hit is not None]
    return min(hits, key=lambda each: each.t, default=None)


def index_of(alone: tuple[Alone, ...], hit: RayHit) -> int:
    """Return the index of the object that gave a hit."""
    return next(each.index for each in alone if each.hit is hit)


def guilty(case: ReplayedPixel, ray: Any, right: RayHit | None) -> str:
    """Say what kept the nearest hit, `right`, from being found: the exercise.

    It is an object's own function, or the search: the octree's, or that of the plain list.
    """
    for index in case.probe.careless(ray, None if right is None else right.t):
        return case.shape(index)
    if not case.probe.on("octree"):
        return "TP2.5"
    with case.probe.instead(octree=False):
        hit = case.probe.nearest(ray)
    return "TP4.B1" if same(hit, right) else "TP2.5"


def same(hit: RayHit | None, other: RayHit | None) -> bool:
    """Return whether two hits are at the same distance, or none is one."""
    if hit is None or other is None:
        return hit is other
    return not far(hit.t, other.t, FAR_T)
