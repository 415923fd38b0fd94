"""The light of a hit: values held against the maps, or against what they are made of."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from grader.checking.expected_data import Array
from grader.evaluation.replay import search
from grader.evaluation.replay.case import ReplayedPixel, WrongValue, outside, told, unlike
from grader.evaluation.replay.expected_maps import Wanted
from grader.evaluation.replay.probe import unit
from grader.evaluation.replay.ray_tree import Alone, Lit, Node, RayHit

_IMAGE = 2
_ASIDE = 0.01  # by how much a way to a light is turned, to see whether it is a close call
_EXACT = 5e-4  # of colours: as near as the maps tell
_SHINY = 5e-3  # ten times that
_CLEAR = 0.01  # scene units: what stands nearer to an end of the way is a close call


def lights(case: ReplayedPixel, node: Node, depth: int) -> Iterator[WrongValue]:
    """Hold what each light adds, and whether it is seen, against the maps or the objects."""
    if not node.lights or node.hit is None or node.toward_eye is None:
        return
    yield from _no_numbers(case, node, depth)
    expected = case.wanted if depth == 0 and case.wanted is not None else None
    mask = expected.of(node.object) if expected is not None else None
    if expected is not None and mask is not None and mask.any():
        yield from _shading(case, node, expected, mask)
    else:
        expected = None
    for lit in node.lights:
        yield from _shadow(case, node.hit, lit, expected, depth)
    yield from _sum(case, node, depth)


def _shading(
    case: ReplayedPixel, node: Node, expected: Wanted, mask: Array
) -> Iterator[WrongValue]:
    assert node.hit is not None
    assert node.toward_eye is not None
    toward = np.stack([each.toward for each in node.lights])
    # The maps were made with a texture of their own.
    kd = expected.kd[mask][0] if node.hit.material["pattern"] == _IMAGE else None
    with case.probe.instead(fresnel=False):
        plain = case.probe.shade(node.hit, node.toward_eye, toward, kd)
        lobe = case.probe.shade(node.hit, node.toward_eye, toward, np.zeros(3, np.float32))
    wanted, low, high = expected.plain[mask], expected.low[mask], expected.high[mask]
    for lit in node.lights:
        k = lit.index
        # Who looks at no option gives Fresnel's at once.
        either = (
            np.concatenate([wanted[:, k], low[:, k]]),
            np.concatenate([wanted[:, k], high[:, k]]),
        )
        if outside(plain[k], *either):
            yield WrongValue("shade", "TP3.1", light=k, wanted=told(wanted[0, k]))
    if not case.probe.on("fresnel"):
        return
    yield from _fresnel(case, node.hit, node.toward_eye, expected.fresnel[mask])
    adds = case.probe.shade(node.hit, node.toward_eye, toward, kd)
    for lit in node.lights:
        k = lit.index
        # A lobe that is wrong by itself may show only here: it must be told that it is right.
        known = lobe[k].max() > _SHINY and _is_exact(plain[k], wanted[:, k])
        if known and outside(adds[k], low[:, k], high[:, k]):
            yield WrongValue("shade", "TP5.2", light=k, wanted=told(low[0, k]), named="shade")


def _is_exact(got: Array, wanted: Array) -> bool:
    return bool((np.abs(wanted - got).max(axis=1) <= _EXACT * (1 + np.abs(got).max())).any())


def _no_numbers(case: ReplayedPixel, node: Node, depth: int) -> Iterator[WrongValue]:
    """Find lights for which shade gives no number, though all that it is given are numbers."""
    assert node.hit is not None
    assert node.toward_eye is not None
    given = (node.hit.normal, node.toward_eye, node.hit.material["kd"])
    broken = [each for each in node.lights if not np.isfinite(each.adds).all()]
    if not broken or not all(np.isfinite(each).all() for each in given):
        return
    toward = np.stack([each.toward for each in node.lights])
    with case.probe.instead(fresnel=False):
        plain = case.probe.shade(node.hit, node.toward_eye, toward)
    for lit in broken:
        if np.isfinite(lit.toward).all() and not np.isfinite(plain[lit.index]).all():
            yield WrongValue("shade", "TP3.1", depth, lit.index)


def _fresnel(case: ReplayedPixel, hit: RayHit, v: Array, wanted: Array) -> Iterator[WrongValue]:
    k = case.probe.call("fresnel_schlick", hit.material["kr"], hit.normal, v).result
    if outside(k, wanted, wanted):
        yield WrongValue("fresnel", "TP5.1", wanted=told(wanted[0]), named="fresnel_schlick")


def _shadow(
    case: ReplayedPixel, hit: RayHit, lit: Lit, expected: Wanted | None, depth: int
) -> Iterator[WrongValue]:
    """Hold whether a light is seen against what each object says of the way to it, and the maps."""
    if lit.n_l <= 0 or lit.seen is None or not np.isfinite(lit.toward).all():
        return
    ways, value = _ways(case, hit, lit), "seen" if lit.seen else "hidden"
    said = case.probe.alone_each(ways)
    alone = said[0]
    yield from search.astray(case, ways[0], alone, depth)
    barred = [_bars(*pair) for pair in zip(ways, said, strict=True)]
    if None in barred or len(set(barred)) > 1:
        return  # a close call
    right = search.nearest(alone)
    if barred[0] is not lit.seen:
        blocker = None if expected is None else _unlike(lit, expected)
        if blocker is not None:  # in_shadow says what the objects say: one of them is wrong
            guilty = blocker if right is None else search.index_of(alone, right)
            yield WrongValue(value, case.shape(guilty), depth, lit.index)
    elif search.same(case.probe.nearest(ways[0]), right):
        yield WrongValue(value, "TP4.1", depth, lit.index)
    else:
        yield WrongValue("object", search.guilty(case, ways[0], right), depth)


def _unlike(lit: Lit, expected: Wanted) -> int | None:
    """Return what bars the light by the maps, or -1, where they say that it is otherwise."""
    if expected.is_behind(lit.index):
        return None
    fits = expected.may_be_seen if lit.seen else expected.may_be_hidden
    return None if fits(lit.index) else int(expected.blocker[0, lit.index])


def _ways(case: ReplayedPixel, hit: RayHit, lit: Lit) -> list[Any]:
    """Return the shadow ray to a light, and others right beside it."""
    epsilon = float(case.probe.content.options["epsilon"])
    distance = np.linalg.norm(case.probe.content.lights["position"][lit.index] - hit.position)
    side = unit(np.cross(lit.toward, np.eye(3, dtype=np.float32)[np.argmin(np.abs(lit.toward))]))
    other = np.cross(lit.toward, side)
    made = []
    for aside in (0 * side, side, -side, other, -other):
        ray = np.zeros((), case.root.ray.dtype)
        ray["dir"] = unit(lit.toward + _ASIDE * aside)
        ray["orig"] = hit.position + epsilon * ray["dir"]
        ray["tmax"] = distance - 2 * epsilon
        ray["seed"] = 1
        made.append(ray)
    return made


def _bars(way: Any, alone: Sequence[Alone]) -> bool | None:
    """Return whether an object bars a way by far; None for a close call."""
    hits = [each.hit.t for each in alone if each.hit is not None]
    if not hits:
        return False
    return True if any(_CLEAR < t < way["tmax"] - _CLEAR for t in hits) else None


def _sum(case: ReplayedPixel, node: Node, depth: int) -> Iterator[WrongValue]:
    """Hold direct_light against the sum of what its lights add."""
    if node.direct is None or node.hit is None:
        return
    whole = _total([each for each in node.lights if each.counts])
    if not unlike(node.direct, whole) or _shadowed_all_the_same(case, node):
        return
    with case.probe.instead(shadows=False):
        direct = case.probe.call("direct_light", node.hit.it, node.toward_eye).result
    every = _total([each for each in node.lights if each.n_l > 0])
    by_shadows = case.probe.on("shadows") and not unlike(direct, every)
    yield WrongValue(
        "direct",
        "TP4.1" if by_shadows else "TP3.2",
        depth,
        wanted=told(whole),
        named="direct_light",
    )


def _shadowed_all_the_same(case: ReplayedPixel, node: Node) -> bool:
    """Return whether direct_light looks for shadows though they are off."""
    if case.probe.on("shadows") or node.hit is None or node.direct is None:
        return False
    every = case.probe.content.lights
    hidden = case.probe.many("in_shadow", len(every), node.hit.it, every).result
    seen = [each for each in node.lights if each.n_l > 0 and not hidden[each.index]]
    return not unlike(node.direct, _total(seen))


def _total(lights: Sequence[Lit]) -> Array:
    added: Array = np.sum([each.adds for each in lights] or [np.zeros(3)], axis=0)
    return added
