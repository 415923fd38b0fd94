"""TP4: shadows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from grader.authoring.expected.vectors.maker import (
    Maker,
    Question,
    Recipe,
    floats,
    norm1,
    stack,
)
from grader.authoring.expected.vectors.scenes import cloud
from grader.authoring.expected.vectors.tp2 import COLOR, COLOR_REASON
from grader.checking.expected_data import Array, Batch

CASES = 120
REASON = "a unit vector: a few float operations"
YES_OR_NO = "the answer is yes or no"


def recipes() -> list[Recipe]:
    """Return how the suites of shadows are made."""
    return _shadows()


def asked(make: Callable[[Maker], list[Batch]], m: Maker) -> list[Question]:
    """Return the batches that `make` gives as questions; empty ones are left out."""
    return [Question(each) for each in make(m) if each.count]


# ---- Shadows ------------------------------------------------------------------------------------


def _barred(m: Maker, scene: Array, position: Array, light: Array, **settings: Array) -> Batch:
    """Return points and one light, which is that of the scene unless `settings` say otherwise."""
    way = norm1(light - position) if (light != position).any() else floats([[0, 1, 0]])
    hits = m.hits(position, way, m.materials(len(position)))
    lights = m.lights(np.repeat(light, len(position), axis=0), (1, 1, 1))
    world = {**m.world(scene, lights[:1]), **settings}
    return Batch("in_shadow", {"it": hits, "from": lights}, world)


def _shadows() -> list[Recipe]:
    suites: dict[str, Callable[[Maker], list[Batch]]] = {
        "blocked": _blocked,
        "near": _close,
        "kinds": _kinds,
        "which": _which,
        "beyond": partial(_in_between, 1),
        "behind": partial(_in_between, -1),
        "own": _own,
        "at_light": _at_light,
    }
    made = [
        Recipe(f"in_shadow.{name}", partial(asked, make), 0.0, YES_OR_NO)
        for name, make in suites.items()
    ]
    return [*made, Recipe("in_shadow.used", lambda m: [_used(m)], COLOR, COLOR_REASON)]


def ball(m: Maker) -> Array:
    """Return the unit sphere."""
    return m.objects("SPHERE", 1, center=(0, 0, 0), radius=1)


def _blocked(m: Maker) -> list[Batch]:
    """Return points around spheres, far from them or from the light, and one light each time."""
    plain = [
        _barred(m, ball(m), floats([(0, -3, 0), (3, 0, 0)]), floats([(0, 3, 0)])),
        _barred(m, ball(m), floats([(0, -3, 0), (3, 0, 0)]), floats([(5, 4, 0)])),
    ]
    return [*plain, *_drawn(m, cloud(m, 9)), *_just_before(m)]


def _drawn(m: Maker, scene: Array) -> list[Batch]:
    """Return points at random around a scene, on several sides of it."""
    made = []
    for light in m.unit(3) * 7:
        start = np.asarray(m.unit(CASES) * 6, np.float32)
        batch = _barred(m, scene, start, light[None])
        # What bars the way may be of the same material.
        batch.args["it"]["mat"][::3] = scene["mat"][np.arange(0, CASES, 3) % len(scene)]
        made.append(m.steady(m.steady(batch, "it.position", 0.05), "from.position", 0.05))
    return made


def _kinds(m: Maker) -> list[Batch]:
    """Return objects of each kind in the way, of glass and of mirrors, alone and among others."""
    floor = m.objects("PLANE", 1, normal=(0, 1, 0), dist=0)
    tall = [
        m.objects(kind, 1, base=(0, -1, 0), axis=(0, 1, 0), length=2, radius=1)
        for kind in ("CYLINDER", "CONE")
    ]
    glass, mirror = ball(m), ball(m)
    glass["mat"]["refraction_index"], mirror["mat"]["ks"] = 1.5, 1
    place = floats([(0.1, -3, 0.1), (0.2, -2, 0), (9, -3, 0)])
    single = [*floor[None], *tall, glass, mirror]
    made = [_barred(m, each, place, floats([(0.1, 3, 0)])) for each in single]
    return [*made, _barred(m, stack(cloud(m, 3), *tall), place, floats([(0.1, 3, 0)]))]


def _which(m: Maker) -> list[Batch]:
    """Return lights that are not the first of the scene's."""
    place = floats([(0, -3, 0), (3, 0, 0)])
    others = m.lights([(0, 3, 0), (9, -3, 0)], (1, 1, 1))
    lights = [others[::-1], others]
    ways = floats([(0, 3, 0), (9, -3, 0)])
    return [
        _barred(m, ball(m), place, way[None], lights=each)
        for way, each in zip(ways, lights, strict=True)
    ]


def _close(m: Maker) -> list[Batch]:
    """Return points that a small sphere nearly touches, on their way to the light."""
    made = []
    for light in floats([(0, 3, 0), (4, 0, 0), (0, 0, -5)]):
        for away in (0.03, 0.006):
            center = norm1(light) * np.float32(away)
            small = m.objects("SPHERE", 1, center=center, radius=away / 3)
            made.append(_barred(m, small, floats([(0, 0, 0)]), light[None]))
    return made


def _in_between(side: int, m: Maker) -> list[Batch]:
    """Return a light and points on the same side of one sphere: nothing lies between.

    With side 1 the sphere is beyond the light, with -1 it is behind the point.
    """
    made = []
    for away in stack(floats([(0, 1, 0)]), m.unit(2)):
        spread = 0.15 * m.unit(15)
        spread[0] = 0
        if side == 1:
            light = away * np.float32(1.6)
            place = light + (away + spread) * m.uniform(1, 4, 15, 1)
        else:
            light, place = away * np.float32(6), away * np.float32(1.6) + spread
        made.append(_barred(m, ball(m), floats(place), light[None]))
    return made


def _just_before(m: Maker) -> list[Batch]:
    """Return a small sphere close before a light whose distance is no whole number."""
    made = []
    for light in floats([(0, 2.9, 0), (-2.8, 2.4, 1), (0, -1, 4.8)]):
        small = m.objects("SPHERE", 1, center=light * np.float32(0.92), radius=0.1)
        made.append(_barred(m, small, floats([(0, 0, 0)]), light[None]))
    return made


def _own(m: Maker) -> list[Batch]:
    """Points on the surface of an object, lit from above: nothing else is in between."""
    up, radius = floats([(0, 1, 0)]), np.float32(1.5)
    normal = stack(up, m.around(np.tile(up, (60, 1)), 0.5))
    sphere = m.objects("SPHERE", 1, center=(0, 0, 0), radius=radius)
    floor = m.objects("PLANE", 1, normal=(0, 1, 0), dist=0.2)
    ground = m.uniform(-3, 3, 60, 3)
    ground[0] = 0
    ground[:, 1] = -0.2
    return [
        _barred(m, sphere, normal * radius, floats([(0, 5, 0)])),
        _barred(m, floor, ground, floats([(1, 4, 0)])),
    ]


def _at_light(m: Maker) -> list[Batch]:
    places = floats([(0, 2, 0), (3, 0, 0), (0, 0, -4)])
    # Where nothing stands: a right test of an object may say anything of a direction of length 0.
    nothing = m.core.zeros("object", 0)
    return [_barred(m, nothing, each[None], each[None]) for each in places]


def _used(m: Maker) -> Question:
    """Return direct_light under a sphere: of two lights, one or both are behind it."""
    position = floats([(0, -3, 0), (4, -3, 0), (8, -3, 0), (-4, -3, 0)])
    lights = m.lights([(0, 5, 0), (-8, 5, 0)], [(1, 1, 1), (0.6, 0.5, 0.4)])
    mat = m.materials(4)
    hits = m.hits(position, (0, 1, 0), mat)
    hits["position"][2:] += m.uniform(-0.2, 0.2, 2, 3)
    v = np.tile(floats([0, 1, 0]), (4, 1))
    scene = ball(m)
    batch = Batch("direct_light", {"it": hits, "v": v}, m.world(scene, lights, fresnel=False))
    return Question(batch, (replace(batch, globals=m.world(scene, lights, fresnel=True)),))
