"""What a ray is and what it meets: values held against the maps, or against each other."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from grader.checking.expected_data import Array
from grader.evaluation.replay import search
from grader.evaluation.replay.case import CLOSE, FAR_T, ReplayedPixel, WrongValue, far, told
from grader.evaluation.replay.expected_maps import Wanted
from grader.evaluation.replay.probe import unit
from grader.evaluation.replay.ray_tree import SKY, Kind, Node, RayHit

_CHECKER, _IMAGE = 1, 2
_STILL = 1e-2  # how far a ray's dir may be from unit length


def camera(case: ReplayedPixel) -> Iterator[WrongValue]:
    """Hold the ray of the camera against the contract of camera_ray."""
    ray, camera = case.root.ray, case.probe.content.camera
    (width, height), (i, j) = case.probe.size, case.pixel
    x, y = (i + 0.5 - width / 2) / (width / 2), (j + 0.5 - height / 2) / (height / 2)
    right, top = x * camera["xdir"], y / camera["aspect"] * camera["ydir"]
    direction = unit(camera["center"] + right + top)
    if far(ray["orig"], camera["position"]):
        yield WrongValue("origin", "TP2.1")
    if far(unit(ray["dir"]), direction, CLOSE / 4):
        yield WrongValue("direction", "TP2.1", wanted=told(direction))


def meeting(case: ReplayedPixel, node: Node, depth: int) -> Iterator[WrongValue]:
    """Hold what is met against the maps, or against what each object says alone."""
    if node.is_beyond:
        return
    yield from search.astray(case, node.ray, node.alone, depth)
    expected = case.wanted if depth == 0 else None
    if expected is not None and not expected.meets(node.object):
        yield _other_object(case, node, int(expected.object[0]), float(expected.t[0]))
    if depth == 1 and case.wanted is not None and node.kind is Kind.MIRROR:
        yield from _mirrored(case, node, case.wanted)
    right = search.nearest(node.alone)
    if not search.same(node.hit, right):
        yield WrongValue("object", search.guilty(case, node.ray, right), depth)


def _mirrored(case: ReplayedPixel, node: Node, expected: Wanted) -> Iterator[WrongValue]:
    """Hold the object that the mirror ray meets against the maps."""
    if not expected.meets(case.root.object) or node.object in expected.mirrored:
        return
    if case.root.hit is None or not case.tells_start(case.root.hit.position):
        return
    wanted = int(expected.mirrored[0])
    index = node.object if node.object >= 0 else wanted
    if len(set(expected.mirrored.tolist())) == 1 and index >= 0:
        yield WrongValue("object", case.shape(index), 1)


def _other_object(case: ReplayedPixel, node: Node, index: int, t: float) -> WrongValue:
    """Say why another object is met than the one expected: `index`, at the distance t."""
    if index != SKY:
        hit = case.probe.ask(index, node.ray)
        own = _length(node) * hit.t if hit is not None else np.nan
        if far(own, t, FAR_T):
            return WrongValue("missed" if hit is None else "t", case.shape(index), wanted=told(t))
    front = {each.index: each.hit.t for each in node.alone if each.hit is not None}
    found = front.get(node.object)
    if found is not None and index != SKY and _length(node) * found < t * (1 - FAR_T):
        return search.false_hit(case, node.ray, node.object)
    if found is not None and index == SKY:
        return WrongValue("met", case.shape(node.object))
    if front and index == SKY:
        return WrongValue("met", case.shape(next(iter(front))))
    return WrongValue("object", search.guilty(case, node.ray, search.nearest(node.alone)))


def surface(case: ReplayedPixel, node: Node, depth: int) -> Iterator[WrongValue]:
    """Hold t, the point, the normal and the material of a hit against what they should be."""
    hit = node.hit
    if hit is None or node.object < 0:
        return
    exercise = case.shape(node.object)
    expected = case.wanted if depth == 0 else None
    mask = expected.of(node.object) if expected is not None else np.zeros(0, bool)
    known = expected if mask.any() else None
    if known is not None:
        yield from _distance(_length(node) * hit.t, known.t[mask], exercise)
    point = node.ray["orig"] + np.float32(hit.t) * node.ray["dir"]
    if far(hit.position, point, FAR_T):
        yield WrongValue("position", exercise, depth, wanted=told(point))
    if far(np.linalg.norm(hit.normal), 1):
        yield WrongValue("normal", exercise, depth)
    if known is not None:
        apart = np.abs(known.normal[mask] - hit.normal).max(axis=1)
        if not (apart <= CLOSE).any():
            yield WrongValue("normal", exercise, depth, wanted=told(known.normal[mask][0]))
    yield from _material(case, node, depth)
    if known is not None:
        yield from _pattern(case, hit, known.kd[mask])


def _distance(t: float, wanted: Array, exercise: str) -> Iterator[WrongValue]:
    if not (np.abs(wanted - t) <= FAR_T * (1 + t)).any():
        yield WrongValue("t", exercise, wanted=told(float(wanted[0])))


def _material(case: ReplayedPixel, node: Node, depth: int) -> Iterator[WrongValue]:
    """Hold the copy of the material against the object's own."""
    assert node.hit is not None
    own, exercise = case.probe.content.objects["mat"][node.object], case.shape(node.object)
    names = ("ks", "kr", "shininess", *(("kd",) if own["pattern"] == 0 else ()))
    for name in names:
        if far(node.hit.material[name], own[name]):
            yield WrongValue("material", exercise, depth, wanted=told(own[name]))


def _pattern(case: ReplayedPixel, hit: RayHit, wanted: Array) -> Iterator[WrongValue]:
    """Hold the colour of a pattern against the maps, shape (count, 3)."""
    pattern = int(hit.material["pattern"])
    if pattern == _CHECKER:
        exercise, kd = "TP3.B1", hit.material["kd"]
    elif pattern == _IMAGE:
        exercise, kd = "TP3.B2", case.probe.textured(hit, case.texels)
    else:
        return
    if not (np.abs(wanted - kd).max(axis=1) <= CLOSE).any():
        yield WrongValue("kd", exercise, wanted=told(wanted[0]))


def _length(node: Node) -> float:
    """Return the length of the ray's dir; the maps' t is that of a unit one."""
    length = float(np.linalg.norm(node.ray["dir"]))
    return 1.0 if abs(length - 1) < _STILL else length
