"""The light of one more ray: held against the contracts, and against what it is made of."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from grader.checking.expected_data import Array
from grader.evaluation.replay.case import ReplayedPixel, WrongValue, far, told, unlike
from grader.evaluation.replay.probe import unit
from grader.evaluation.replay.ray_tree import Bounce, Kind, Node, RayHit

_ENDLESS = 100.0  # scene units: no bounced ray may stop before
_DRAWS = 256  # of glass_color, to see how often it reflects
_ODDS = 0.15  # how far the share of reflections may be from its probability: 5 deviations
_CRITICAL = 0.02  # of the sine squared: nearer to total reflection rounding decides


def bounce(case: ReplayedPixel, node: Node, depth: int) -> Iterator[WrongValue]:
    """Hold the next ray and its colour against the contracts."""
    bounced, hit = node.bounce, node.hit
    if bounced is None or hit is None:
        return
    if case.probe.on("refraction") and hit.is_transparent:
        yield from _glass(case, node, bounced, hit, depth)
        return
    yield from _reflected(case, node, bounced.ray, hit, depth)
    if case.probe.on("fresnel"):
        yield from _schlick(node, bounced, hit, depth)
    if unlike(bounced.color, bounced.k * bounced.seen) and not _fresnel_all_the_same(case, node):
        yield WrongValue(
            "mirror",
            _of_mirror(case, node),
            depth,
            wanted=told(bounced.k * bounced.seen),
            named="mirror_color",
        )


def _schlick(node: Node, bounced: Bounce, hit: RayHit, depth: int) -> Iterator[WrongValue]:
    """Hold Fresnel's coefficient against the contract of fresnel_schlick."""
    assert node.toward_eye is not None
    kr, cosine = hit.material["kr"], np.clip(node.toward_eye @ hit.normal, 0, 1)
    k = kr + (1 - kr) * (1 - cosine) ** 5
    if far(bounced.k, k):
        yield WrongValue("fresnel", "TP5.1", depth, wanted=told(k), named="fresnel_schlick")


def _reflected(
    case: ReplayedPixel, node: Node, out: Any, hit: RayHit, depth: int
) -> Iterator[WrongValue]:
    """Hold the mirror ray against the contract of reflected_ray."""
    arriving = node.ray["dir"]
    direction = unit(arriving - 2 * float(arriving @ hit.normal) * hit.normal)
    if far(out["dir"], direction):
        yield WrongValue("reflected", "TP4.2", depth, wanted=told(direction))
    yield from _made(case, node, out, hit, depth, "TP4.2")


def _made(
    case: ReplayedPixel, node: Node, out: Any, hit: RayHit, depth: int, exercise: str
) -> Iterator[WrongValue]:
    """Hold what every bounced ray has in common: start, range, depth."""
    epsilon = case.probe.content.options["epsilon"]
    moved = np.linalg.norm(out["orig"] - hit.position)
    if case.tells_start(hit.position) and not epsilon / 50 <= moved <= 100 * epsilon:
        yield WrongValue("start", exercise, depth)
    if not out["tmin"] <= 0 or not out["tmax"] >= _ENDLESS:
        yield WrongValue("range", exercise, depth)
    if out["depth"] != node.ray["depth"] + 1:
        yield WrongValue("depth", exercise, depth, wanted=str(node.ray["depth"] + 1))


def _fresnel_all_the_same(case: ReplayedPixel, node: Node) -> bool:
    """Return whether mirror_color uses Fresnel's coefficient though it is off."""
    assert node.bounce is not None
    assert node.hit is not None
    if case.probe.on("fresnel"):
        return False
    material, normal = node.hit.material, node.hit.normal
    k = case.probe.call("fresnel_schlick", material["kr"], normal, node.toward_eye).result
    return not unlike(node.bounce.color, k * node.bounce.seen)


def _of_mirror(case: ReplayedPixel, node: Node) -> str:
    """Say whether mirror_color is wrong by itself, or only with Fresnel."""
    assert node.bounce is not None
    assert node.hit is not None
    if not case.probe.on("fresnel"):
        return "TP4.3"
    with case.probe.instead(fresnel=False):
        color = case.probe.call("mirror_color", node.ray, node.hit.it).result
        seen = case.probe.trace(node.bounce.ray)
    return "TP4.3" if unlike(color, node.hit.material["ks"] * seen) else "TP5.2"


def _glass(
    case: ReplayedPixel, node: Node, bounced: Bounce, hit: RayHit, depth: int
) -> Iterator[WrongValue]:
    """Hold the refracted ray against Snell's law, then what glass_color draws."""
    if far(np.linalg.norm(hit.normal), 1):
        return
    mirrored, through = case.probe.reflected(node.ray, hit), case.probe.refracted(node.ray, hit)
    yield from _reflected(case, node, mirrored, hit, depth)
    yield from _refracted(case, node, through, hit, depth)
    if unlike(bounced.color, bounced.seen):
        yield WrongValue("glass", "TP5.B1", depth, named="glass_color")
    elif depth == 0:
        if case.probe.on("fresnel"):
            yield from _normal_incidence(case, hit)
        yield from _drawn(case, node, hit)


def _refracted(
    case: ReplayedPixel, node: Node, out: Any | None, hit: RayHit, depth: int
) -> Iterator[WrongValue]:
    arriving, index = unit(node.ray["dir"]), float(hit.material["refraction_index"])
    ratio = index if float(arriving @ hit.normal) > 0 else 1 / index
    # Snell: what goes along the surface is multiplied by the ratio of the indices.
    along = ratio * (arriving - float(arriving @ hit.normal) * hit.normal)
    sine = float(along @ along)
    if out is None or sine > 1:
        if abs(sine - 1) > _CRITICAL and (out is None) is not (sine > 1):
            yield WrongValue("total" if out is None else "through", "TP5.B1", depth)
        return
    direction = out["dir"]
    across = float(direction @ hit.normal)
    wrong = far(np.linalg.norm(direction), 1) or far(direction - across * hit.normal, along)
    if wrong or across * float(arriving @ hit.normal) < 0:
        yield WrongValue("refracted", "TP5.B1", depth)
    yield from _made(case, node, out, hit, depth, "TP5.B1")
    if node.object >= 0 and across < 0 and case.probe.ask(node.object, out) is None:
        yield WrongValue("missed", case.shape(node.object), depth + 1)  # it starts inside


def _normal_incidence(case: ReplayedPixel, hit: RayHit) -> Iterator[WrongValue]:
    index = float(hit.material["refraction_index"])
    kr = ((1 - index) / (1 + index)) ** 2
    if far(case.probe.call("reflectance", 1.0, index).result, kr):
        yield WrongValue("reflectance", "TP5.1", wanted=told(kr))


def _drawn(case: ReplayedPixel, node: Node, hit: RayHit) -> Iterator[WrongValue]:
    """Hold how often glass_color reflects against the probability that Fresnel gives."""
    probe = case.probe
    rays = np.repeat(np.asarray(node.ray)[None], _DRAWS)
    rays["seed"] = probe.many(
        "pixel_seed", _DRAWS, *case.pixel, np.arange(_DRAWS, dtype=np.int32)
    ).result
    reply = probe.many("glass_color", _DRAWS, rays, hit.it)
    after, colors = reply.args["in"], reply.result
    mirrored = probe.many("reflected_ray", _DRAWS, np.zeros_like(after), after, hit.it).args["out"]
    reply = probe.many("refracted_ray", _DRAWS, np.zeros_like(after), after, hit.it)
    if not reply.result.all():
        return  # total reflection leaves no choice
    seen = [probe.many("trace_ray", _DRAWS, each).result for each in (mirrored, reply.args["out"])]
    off, through = (np.abs(each - colors).max(axis=1) for each in seen)
    told_apart = np.abs(off - through) > 1e-3
    if told_apart.sum() < _DRAWS / 2:
        return
    share = float((off < through)[told_apart].mean())
    if abs(share - _probability(case, node, hit)) > _ODDS:
        yield WrongValue("odds", "TP5.B1", named="glass_color")


def _probability(case: ReplayedPixel, node: Node, hit: RayHit) -> float:
    """Return how often the ray should be reflected, by the submission's own functions."""
    if not case.probe.on("fresnel"):
        return float(np.mean(hit.material["ks"]))
    index = hit.material["refraction_index"]
    kr = case.probe.call("reflectance", 1.0, index).result
    v = unit(-node.ray["dir"])
    normal: Array = hit.normal if float(v @ hit.normal) > 0 else -hit.normal
    k = case.probe.call("fresnel_schlick", np.full(3, kr, np.float32), normal, v).result
    return float(np.asarray(k)[0])


def transparent(root: Node) -> bool:
    """Return whether what is seen depends on how rays are drawn."""
    return any(each.kind is Kind.REFRACTED for each in root.walk()) or any(
        each.hit is not None and each.hit.is_transparent for each in root.walk()
    )
