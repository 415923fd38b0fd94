"""What a ray is and what it meets: values held against the maps, or against each other."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from grader.lab.inspector.case import CLOSE, FAR_T, Case, Fault, far, told
from grader.lab.inspector.maps import Wanted
from grader.lab.inspector.nodes import SKY, Alone, Kind, Node
from grader.lab.inspector.probe import unit
from grader.lab.values import Hit
from grader.lab.vectors import Array

_SHAPES = {1: "TP2.4", 2: "TP2.3", 3: "TP2.B1", 4: "TP2.B2"}
_CHECKER = 1
_STILL = 1e-2  # how far a ray's dir may be from unit length


def camera(case: Case) -> Iterator[Fault]:
    """Hold the ray of the camera against the contract of camera_ray."""
    ray, camera = case.root.ray.data, case.probe.scene.camera.data
    (width, height), (i, j) = case.probe.size, case.pixel
    x, y = (i + 0.5 - width / 2) / (width / 2), (j + 0.5 - height / 2) / (height / 2)
    right, top = x * camera["xdir"], y / camera["aspect"] * camera["ydir"]
    direction = unit(camera["center"] + right + top)
    if far(ray["orig"], camera["position"]):
        yield Fault("origin", "TP2.1")
    if far(unit(ray["dir"]), direction, CLOSE / 4):
        yield Fault("direction", "TP2.1", wanted=told(direction))


def meeting(case: Case, node: Node, depth: int) -> Iterator[Fault]:
    """Hold what is met against the maps, or against what each object says alone."""
    if node.hit is None:
        return
    for each in node.alone:
        if each.spoilt:
            yield Fault("miss", _shape(case, each.index), depth)
    expected = case.wanted if depth == 0 else None
    if expected is not None and not expected.meets(node.object):
        yield _other_object(case, node, int(expected.object[0]), float(expected.t[0]))
    if depth == 1 and case.wanted is not None and node.kind is Kind.MIRROR:
        yield from _mirrored(case, node, case.wanted)
    nearest = _nearest(node)
    wrong = node.met if nearest is None else far(_t(node), nearest.hit.t, FAR_T)
    if wrong:
        yield Fault("object", _search(case, node), depth)


def _mirrored(case: Case, node: Node, expected: Wanted) -> Iterator[Fault]:
    """Hold the object that the mirror ray meets against the maps."""
    if not expected.meets(case.root.object) or node.object in expected.mirrored:
        return
    wanted = int(expected.mirrored[0])
    index = node.object if node.object >= 0 else wanted
    if len(set(expected.mirrored.tolist())) == 1 and index >= 0:
        yield Fault("object", _shape(case, index), 1)


def _other_object(case: Case, node: Node, index: int, t: float) -> Fault:
    """Say why another object is met than the one expected: `index`, at the distance t."""
    if index != SKY:
        hit = case.probe.ask(index, node.ray)
        own = _length(node) * float(hit.t) if hit else np.nan
        if far(own, t, FAR_T):
            return Fault("t" if hit else "missed", _shape(case, index), wanted=told(t))
    front = [each for each in node.alone if each.hit and (index == SKY or each.hit.t < _t(node))]
    found = next((each for each in node.alone if each.index == node.object), None)
    if found is not None and (index == SKY or _length(node) * found.hit.t < t * (1 - FAR_T)):
        return Fault("met", _shape(case, found.index))
    if front and index == SKY:
        return Fault("met", _shape(case, front[0].index))
    return Fault("object", _search(case, node))


def surface(case: Case, node: Node, depth: int) -> Iterator[Fault]:
    """Hold t, the point, the normal and the material of a hit against what they should be."""
    if not node.met or node.object < 0 or node.hit is None:
        return
    exercise, hit = _shape(case, node.object), node.hit
    expected = case.wanted if depth == 0 else None
    mask = expected.of(node.object) if expected is not None else np.zeros(0, bool)
    if expected is not None and mask.any():
        t = _length(node) * hit.t
        if not (np.abs(expected.t[mask] - t) <= FAR_T * (1 + t)).any():
            yield Fault("t", exercise, depth, wanted=told(float(expected.t[mask][0])))
    if far(hit.data["position"], node.ray.at(hit.t), FAR_T):
        yield Fault("position", exercise, depth, wanted=told(node.ray.at(hit.t)))
    if far(np.linalg.norm(hit.data["normal"]), 1):
        yield Fault("normal", exercise, depth)
    if expected is not None and mask.any():
        apart = np.abs(expected.normal[mask] - hit.data["normal"]).max(axis=1)
        if not (apart <= CLOSE).any():
            yield Fault("normal", exercise, depth, wanted=told(expected.normal[mask][0]))
    yield from _material(case, node, depth, expected, mask)


def _material(
    case: Case, node: Node, depth: int, expected: Wanted | None, mask: Array
) -> Iterator[Fault]:
    """Hold the copy of the material against the object's own; its kd against the maps."""
    hit = node.hit
    if hit is None:
        return
    own, exercise = case.probe.scene.objects.data["mat"][node.object], _shape(case, node.object)
    for name in ("ks", "kr", "shininess"):
        if far(hit.data["mat"][name], own[name]):
            yield Fault("material", exercise, depth, wanted=told(own[name]))
    kd, pattern = hit.data["mat"]["kd"], int(own["pattern"])
    if pattern == 0 and far(kd, own["kd"]):
        yield Fault("material", exercise, depth, wanted=told(own["kd"]))
    if pattern == _CHECKER and expected is not None and mask.any():
        apart = np.abs(expected.kd[mask] - kd).max(axis=1)
        if not (apart <= CLOSE).any():
            yield Fault("kd", "TP3.B1", depth, wanted=told(expected.kd[mask][0]))


def _nearest(node: Node) -> Alone | None:
    hits = [each for each in node.alone if each.hit]
    return min(hits, key=lambda each: float(each.hit.t), default=None)


def _search(case: Case, node: Node) -> str:
    """Say what kept the nearest object from being found: an object's own function, or the search.

    The search is the octree's, or that of the plain list.
    """
    nearest = _nearest(node)
    for index in case.probe.careless(node.ray, None if nearest is None else nearest.hit.t):
        return _shape(case, index)
    if not case.probe.on("octree"):
        return "TP2.5"
    with case.probe.instead(octree=False):
        hit: Hit = case.probe.call("nearest_hit", node.ray)
    right = not hit if nearest is None else bool(hit) and not far(hit.t, nearest.hit.t, FAR_T)
    return "TP4.B1" if right else "TP2.5"


def _shape(case: Case, index: int) -> str:
    return _SHAPES[int(case.probe.scene.objects.data["type"][index])]


def _t(node: Node) -> float:
    return float(node.hit.t) if node.hit is not None else np.nan


def _length(node: Node) -> float:
    """Return the length of the ray's dir; the maps' t is that of a unit one."""
    length = float(np.linalg.norm(node.ray.data["dir"]))
    return 1.0 if abs(length - 1) < _STILL else length
