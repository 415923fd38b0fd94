"""TP4: shadows and mirrors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from grader.authoring.expected.vectors import tp2
from grader.authoring.expected.vectors.maker import (
    Maker,
    Question,
    Recipe,
    floats,
    norm1,
)
from grader.authoring.expected.vectors.tp2 import COLOR, COLOR_REASON, EXACT_ENOUGH
from grader.checking.expected_data import Array, Batch

CASES = 120
REASON = "a unit vector: a few float operations"
YES_OR_NO = "the answer is yes or no"


def recipes() -> list[Recipe]:
    """Return how the suites of TP4 are made."""
    return [*_shadows(), *_reflections(), *_mirrors()]


def asked(make: Callable[[Maker], list[Batch]], m: Maker) -> list[Question]:
    """Return the batches that `make` gives as questions; empty ones are left out."""
    return [Question(each) for each in make(m) if each.count]


# ---- Shadows ------------------------------------------------------------------------------------


def _barred(m: Maker, scene: Array, position: Array, light: Array, normal: Array) -> Batch:
    hits = m.hits(position, normal, m.materials(len(position)))
    lights = m.lights(light, (1, 1, 1))
    return Batch("in_shadow", {"it": hits, "from": lights}, m.world(scene))


def _shadows() -> list[Recipe]:
    suites: dict[str, Callable[[Maker], list[Batch]]] = {
        "blocked": _blocked,
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
    plain = _barred(
        m,
        ball(m),
        floats([(0, -3, 0), (3, 0, 0), (0, -3, 0), (0, 3, 0)]),
        floats([(0, 3, 0), (3, 5, 0), (5, -3, 0), (0, -3, 0)]),
        floats([0, 1, 0]),
    )
    cloud = tp2.cloud(m, 9)
    start = m.unit(CASES) * 6
    light = np.asarray(-start + m.uniform(-4, 4, CASES, 3), np.float32)
    drawn = _barred(m, cloud, start, light, norm1(light - start))
    drawn = m.steady(m.steady(drawn, "it.position", 0.05), "from.position", 0.05)
    return [plain, drawn, _close(m)]


def _close(m: Maker) -> Batch:
    """Return points that a small sphere nearly touches, on their way to the light."""
    light = floats([(0, 3, 0), (4, 0, 0), (0, 0, -5)])
    small = m.objects("SPHERE", 3, center=norm1(light) * np.float32(0.03), radius=0.01)
    return _barred(m, small, np.zeros((3, 3), np.float32), light, norm1(light))


def _in_between(side: int, m: Maker) -> list[Batch]:
    """Return a light and a point on the same side of one sphere: nothing lies between.

    With side 1 the sphere is beyond the light, with -1 it is behind the point.
    """
    count = 40
    away = m.unit(count)
    away[0] = (0, 1, 0)
    near, far = away * m.uniform(1.3, 2, count, 1), away * m.uniform(3, 6, count, 1)
    near[0], far[0] = (0, 2, 0), (0, 4, 0)
    start, light = (far, near) if side == 1 else (near, far)
    return [_barred(m, ball(m), start, light, norm1(light - start))]


def _own(m: Maker) -> list[Batch]:
    """Points on the surface of an object, lit from above: nothing else is in between."""
    count = 60
    normal, radius = m.unit(count), 1.5
    normal[0] = (0, 1, 0)
    light = (normal * 1.5 + m.around(normal, 0.2) * m.uniform(2, 9, count, 1)).astype(np.float32)
    light[0] = (0, 5, 0)
    ball = m.objects("SPHERE", 1, center=(0, 0, 0), radius=radius)
    floor = m.objects("PLANE", 1, normal=(0, 1, 0), dist=0.2)
    ground = m.uniform(-3, 3, count, 3)
    ground[0] = 0
    ground[:, 1] = -0.2
    above = ground + m.around(np.tile(floats([0, 1, 0]), (count, 1)), 0.2) * 4
    return [
        _barred(m, ball, normal * np.float32(radius), light, normal),
        _barred(m, floor, ground, above, floats([0, 1, 0])),
    ]


def _at_light(m: Maker) -> list[Batch]:
    place = floats([(0, 2, 0), (3, 0, 0), (0, 0, -4)])
    return [_barred(m, ball(m), place, place, floats([0, 1, 0]))]


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


# ---- Mirrors ------------------------------------------------------------------------------------


def arriving(m: Maker, count: int, low: float = 0.1) -> tuple[Array, Array]:
    """Return unit normals, and unit directions that arrive on their side; the first are plain."""
    normal = m.unit(count)
    normal[:2] = (0, 1, 0)
    direction = -m.around(normal, low, 0.95)
    direction[:2] = norm1([(0, -1, 0), (0.6, -0.8, 0)])
    return normal, direction


def _reflections() -> list[Recipe]:
    return [
        Recipe(f"reflected_ray.{name}", partial(asked, make), EXACT_ENOUGH, REASON)
        for name, make in {"unit": _reflected, "scaled": _scaled}.items()
    ]


def _reflected(m: Maker) -> list[Batch]:
    normal, direction = arriving(m, CASES)
    position = m.uniform(-3, 3, CASES, 3)
    position[:2] = 0
    distance = m.uniform(1, 5, CASES, 1)
    distance[:2] = 2
    start = position - direction * distance
    rays = m.rays(start, direction, depth=m.rng.integers(0, 9, CASES))
    rays["seed"] = m.rng.integers(2, 1 << 32, CASES, dtype=np.uint32)
    rays["depth"][:2] = 0
    hits = m.hits(position, normal, m.materials(CASES))
    # What the ray that arrives has seen must not bound the one that leaves.
    rays["tmax"] = distance[:, 0]
    args = {"out": m.blank("ray", CASES), "in": rays, "it": hits}
    return [Batch("reflected_ray", args, m.world())]


def _scaled(m: Maker) -> list[Batch]:
    """Return rays that arrive with directions that are not unit."""
    (batch,) = _reflected(m)
    factors = m.uniform(0.2, 5, CASES)
    factors[:2] = 2
    batch.args["in"]["dir"] *= factors[:, None]
    batch.args["in"]["tmax"] /= factors
    return [batch]


def mirrors(m: Maker, scene: Array, count: int, **fields: object) -> Batch:
    """Return calls of mirror_color at points around a scene, whose reflections are clear."""
    normal, direction = arriving(m, count)
    position = m.unit(count) * m.uniform(7, 9, count, 1)
    position[0] = (0, -7, 0)
    if len(scene):  # towards an object, so that the reflection shows it
        target = scene["center"][m.rng.integers(len(scene), size=count)]
        out = norm1(target - position)
        normal = norm1(out - direction)
        keep = np.einsum("ij,ij->i", normal, direction) < -0.1
        normal, direction, position = normal[keep], direction[keep], position[keep]
    mat = m.materials(len(normal), **fields)
    hits = m.hits(position, normal, mat)
    args = {"in": m.rays(position - direction, direction), "it": hits}
    return Batch("mirror_color", args, tp2.lit(m, scene, shading=False, fresnel=False))


def staged(m: Maker, batch: Batch, on: bool = False) -> Question:
    """Return the calls without shading of what is mirrored; with it they are accepted too.

    With `on`, Fresnel decides in all of them.
    """
    question = m.stages(batch)
    if not on:
        return question
    fixed = []
    for each in (question.batch, *question.variants):
        options = each.globals["options"].copy()
        options["fresnel"] = True
        fixed.append(replace(each, globals={**each.globals, "options": options}))
    return Question(fixed[0], tuple(fixed[1:]))


def _mirrors() -> list[Recipe]:
    suites = {"sky": _sky, "object": _mirrored, "depth": _deep}
    return [
        Recipe(f"mirror_color.{name}", partial(_by_either, make), COLOR, COLOR_REASON)
        for name, make in suites.items()
    ]


def _by_either(make: Callable[[Maker], list[Batch]], m: Maker) -> list[Question]:
    """Return calls without Fresnel; with it they are accepted: who has it may ignore the option."""
    made = []
    for batch in make(m):
        plain, on = staged(m, batch), staged(m, batch, on=True)
        made.append(Question(plain.batch, (*plain.variants, on.batch, *on.variants)))
    return made


def _sky(m: Maker) -> list[Batch]:
    sky = mirrors(m, m.core.zeros("object", 0), 60)
    sky.args["it"]["mat"]["ks"][0] = 1
    return [sky]


def _large_ball(m: Maker) -> Array:
    return m.objects("SPHERE", 1, center=(0, 0, 0), radius=2)


def _mirrored(m: Maker) -> list[Batch]:
    scenes = (_large_ball(m), tp2.cloud(m, 6))
    return [m.steady(mirrors(m, each, 60), "it.position", 0.02) for each in scenes]


def _deep(m: Maker) -> list[Batch]:
    deep = mirrors(m, _large_ball(m), 40)
    deep.args["in"]["depth"] = np.choose(np.arange(deep.count) % 4, (0, 12, 5, 10))
    return [deep]
