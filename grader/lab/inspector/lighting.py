"""The light of a hit: values held against the maps, or against what they are made of."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from grader.lab.inspector.case import Case, Fault, far, outside, told
from grader.lab.inspector.maps import Wanted
from grader.lab.inspector.nodes import Bounce, Kind, Lit, Node
from grader.lab.inspector.probe import unit
from grader.lab.values import Hit
from grader.lab.vectors import Array

_IMAGE = 2
_ENDLESS = 100.0  # scene units: no bounced ray may stop before


def lights(case: Case, node: Node, depth: int) -> Iterator[Fault]:
    """Hold what each light adds, and whether it is seen, against the maps."""
    if not node.lights or node.hit is None or node.toward_eye is None:
        return
    expected = case.wanted if depth == 0 and case.wanted is not None else None
    mask = expected.of(node.object) if expected is not None else None
    if expected is not None and mask is not None and mask.any():
        yield from _shading(case, node, expected, mask)
        if case.probe.on("shadows"):
            yield from (each for lit in node.lights for each in _shadow(lit, expected))
    yield from _sum(case, node, depth)


def _shading(case: Case, node: Node, expected: Wanted, mask: Array) -> Iterator[Fault]:
    assert node.hit is not None
    assert node.toward_eye is not None
    toward = np.stack([each.toward for each in node.lights])
    # The maps were made with a texture of their own.
    kd = expected.kd[mask][0] if node.hit.material.pattern == _IMAGE else None
    with case.probe.instead(fresnel=False):
        plain = case.probe.shade(node.hit, node.toward_eye, toward, kd)
    low, high = expected.plain[mask], expected.plain[mask]
    for lit in node.lights:
        if outside(plain[lit.index], low[:, lit.index], high[:, lit.index]):
            value = told(low[0, lit.index])
            yield Fault("shade", "TP3.1", light=lit.index, wanted=value)
    if not case.probe.on("fresnel"):
        return
    yield from _fresnel(case, node, expected, mask)
    adds = case.probe.shade(node.hit, node.toward_eye, toward, kd)
    low, high = expected.low[mask], expected.high[mask]
    for lit in node.lights:
        if outside(adds[lit.index], low[:, lit.index], high[:, lit.index]):
            value = told(low[0, lit.index])
            yield Fault("shade", "TP5.2", light=lit.index, wanted=value)


def _fresnel(case: Case, node: Node, expected: Wanted, mask: Array) -> Iterator[Fault]:
    assert node.hit is not None
    material, normal = node.hit.material, node.hit.data["normal"]
    k = np.asarray(case.probe.call("fresnel_schlick", material.kr, normal, node.toward_eye))
    if outside(k, expected.fresnel[mask], expected.fresnel[mask]):
        yield Fault("fresnel", "TP5.1", wanted=told(expected.fresnel[mask][0]))


def _shadow(lit: Lit, expected: Wanted) -> Iterator[Fault]:
    if lit.n_l <= 0 or expected.is_behind(lit.index):
        return
    fits = expected.may_be_seen if lit.seen else expected.may_be_hidden
    if not fits(lit.index):
        yield Fault("hidden" if not lit.seen else "seen", "TP4.1", light=lit.index)


def _sum(case: Case, node: Node, depth: int) -> Iterator[Fault]:
    """Hold direct_light against the sum of what its lights add."""
    if node.direct is None or node.hit is None:
        return
    added = [each.adds for each in node.lights if each.counts]
    whole = np.sum(added, axis=0) if added else np.zeros(3)
    if not far(node.direct, whole):
        return
    every = np.sum([each.adds for each in node.lights if each.n_l > 0] or [np.zeros(3)], axis=0)
    with case.probe.instead(shadows=False):
        direct = case.probe.call("direct_light", node.hit, node.toward_eye)
    by_shadows = case.probe.on("shadows") and not far(direct, every)
    yield Fault("direct", "TP4.1" if by_shadows else "TP3.2", depth, wanted=told(whole))


def bounce(case: Case, node: Node, depth: int) -> Iterator[Fault]:
    """Hold the mirror ray and its colour against the contracts."""
    bounced, hit = node.bounce, node.hit
    if bounced is None or hit is None:
        return
    if bounced.kind is not Kind.MIRROR or hit.material.refraction_index > 0:
        if far(bounced.color, bounced.seen):
            yield Fault("glass", "TP5.B1", depth)
        return
    yield from _reflected(case, node, bounced, hit, depth)
    if far(bounced.color, bounced.k * bounced.seen):
        yield Fault("mirror", _of_mirror(case, node), depth, wanted=told(bounced.k * bounced.seen))


def _reflected(case: Case, node: Node, bounce: Bounce, hit: Hit, depth: int) -> Iterator[Fault]:
    """Hold the mirror ray against the contract of reflected_ray."""
    arriving, normal, out = node.ray.data["dir"], hit.data["normal"], bounce.ray.data
    direction = unit(arriving - 2 * float(arriving @ normal) * normal)
    if far(out["dir"], direction):
        yield Fault("reflected", "TP4.2", depth, wanted=told(direction))
    epsilon = case.probe.chosen.get("epsilon", 1e-4)
    moved = np.linalg.norm(out["orig"] - hit.data["position"])
    if not epsilon / 10 <= moved <= 100 * epsilon:
        yield Fault("start", "TP4.2", depth)
    if not out["tmin"] <= 0 or not out["tmax"] >= _ENDLESS:
        yield Fault("range", "TP4.2", depth)
    if out["depth"] != node.ray.data["depth"] + 1:
        yield Fault("depth", "TP4.2", depth, wanted=str(node.ray.data["depth"] + 1))


def _of_mirror(case: Case, node: Node) -> str:
    """Say whether mirror_color is wrong by itself, or only with Fresnel."""
    assert node.bounce is not None
    assert node.hit is not None
    if not case.probe.on("fresnel"):
        return "TP4.3"
    with case.probe.instead(fresnel=False):
        color = case.probe.call("mirror_color", node.ray, node.hit)
        seen = case.probe.call("trace_ray", node.bounce.ray)
    return "TP4.3" if far(color, node.hit.data["mat"]["ks"] * seen) else "TP5.2"


def whole(_case: Case, node: Node, depth: int) -> Iterator[Fault]:
    """Hold trace_ray against the sum of its parts."""
    if far(node.trace, node.total):
        yield Fault("trace", "TP2.6", depth, wanted=told(node.total))
