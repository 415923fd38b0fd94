"""TP4: rays that bounce off, and what mirrors show."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from grader.authoring.expected.vectors.bounces import clear
from grader.authoring.expected.vectors.maker import Maker, Question, Recipe, floats, norm1
from grader.authoring.expected.vectors.scenes import cloud
from grader.authoring.expected.vectors.tp2 import COLOR, COLOR_REASON, EXACT_ENOUGH
from grader.authoring.expected.vectors.tp4 import CASES, asked
from grader.checking.expected_data import Array, Batch

REASON = "a unit vector: a few float operations"


def recipes() -> list[Recipe]:
    """Return how the suites of reflections are made."""
    return [*_reflections(), *_mirrors()]


def arriving(m: Maker, count: int, low: float = 0.1) -> tuple[Array, Array]:
    """Return unit normals, and unit directions that arrive on their side; the first are plain."""
    normal = m.unit(count)
    normal[:2] = (0, 1, 0)
    direction = -m.around(normal, low, 0.95)
    direction[:2] = norm1([(0, -1, 0), (0.6, -0.8, 0)])
    return normal, direction


def _reflections() -> list[Recipe]:
    suites = {"unit": _reflected, "scaled": _scaled, "inside": _from_inside}
    return [
        Recipe(f"reflected_ray.{name}", partial(asked, make), EXACT_ENOUGH, REASON)
        for name, make in suites.items()
    ]


def _reflected(m: Maker) -> list[Batch]:
    normal, direction = arriving(m, CASES)
    return [_bouncing(m, normal, direction)]


def _from_inside(m: Maker) -> list[Batch]:
    """Return rays that bounce off a surface from within: the normal points away."""
    normal, direction = arriving(m, CASES)
    return [_bouncing(m, -normal, direction)]


def _bouncing(m: Maker, normal: Array, direction: Array) -> Batch:
    position = m.uniform(-3, 3, CASES, 3)
    position[:2] = 0
    distance = m.uniform(1, 5, CASES, 1)
    distance[:2] = 2
    start = position - direction * distance
    # What the ray that arrives has seen must not bound the one that leaves.
    rays = m.rays(start, direction, tmin=m.uniform(0.2, 0.9, CASES), tmax=distance[:, 0])
    rays["tmin"][:2] = 0
    rays["seed"] = m.rng.integers(2, 1 << 32, CASES, dtype=np.uint32)
    rays["depth"][2:] = m.rng.integers(0, 9, CASES - 2)
    hits = m.hits(position, normal, m.materials(CASES))
    args = {"out": m.blank("ray", CASES), "in": rays, "it": hits}
    return Batch("reflected_ray", args, m.switches())


def _scaled(m: Maker) -> list[Batch]:
    """Return rays that arrive with directions that are not unit."""
    (batch,) = _reflected(m)
    factors = m.uniform(0.2, 5, CASES)
    factors[:2] = 2
    batch.args["in"]["dir"] *= factors[:, None]
    batch.args["in"]["tmax"] /= factors
    return [batch]


def mirrors(m: Maker, scene: Array, count: int, **fields: object) -> Batch:
    """Return calls of mirror_color at points around a scene, whose reflections are clear.

    The light is far above, and the mirrors look down: their own light adds nothing. Their
    coefficient is grey and their kd 1, unless `fields` say otherwise.
    """
    normal, direction = arriving(m, count)
    normal[:2], direction[:2] = -normal[:2], -direction[:2]
    position = m.unit(count) * m.uniform(7, 9, count, 1)
    position[:, 1] = np.abs(position[:, 1])
    position[0] = (0, 7, 0)
    if len(scene):  # towards an object, so that the reflection shows it
        target = scene["center"][m.rng.integers(len(scene), size=count)]
        out = norm1(target - position)
        normal = norm1(out - direction)
        keep = np.einsum("ij,ij->i", normal, direction) < -0.1
    else:
        keep = np.ones(count, bool)
    keep &= normal[:, 1] < -0.05
    normal, direction, position = normal[keep], direction[keep], position[keep]
    grey = m.uniform(0.2, 0.9, len(normal), 1)
    mat = m.materials(len(normal), **{"kd": 1, "ks": grey, "kr": grey, **fields})
    hits = m.hits(position, normal, mat)
    args = {"in": m.rays(position - direction, direction), "it": hits}
    lamp = m.lights([(0, 900, 0)], (1, 1, 1))
    world = m.world(scene, lamp, shading=False, fresnel=False)
    return Batch("mirror_color", args, world)


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
    suites = {
        "sky": _sky,
        "object": _mirrored,
        "depth": _deep,
        "alone": _alone,
        "channels": _colored,
        "bright": _bright,
    }
    return [
        Recipe(f"mirror_color.{name}", partial(_by_either, make), COLOR, COLOR_REASON)
        for name, make in suites.items()
    ]


def _by_either(make: Callable[[Maker], list[Batch]], m: Maker) -> list[Question]:
    """Return calls without Fresnel; with it they are accepted: who has it may ignore the option.

    So are those with all that comes later, but nothing that has no mirrors.
    """
    made = []
    for batch in make(m):
        plain, on = staged(m, batch), staged(m, batch, on=True)
        later = [
            each
            for each in (*plain.variants, on.batch, *on.variants)
            if each.globals["options"]["reflections"] or not each.globals["options"]["shading"]
        ]
        made.append(clear(m, Question(plain.batch, tuple(later)), COLOR / 4))
    return made


def _sky(m: Maker) -> list[Batch]:
    sky = mirrors(m, m.core.zeros("object", 0), 90)
    mat = sky.args["it"]["mat"]
    mat["ks"][0] = 1
    mat["ks"][2::9], mat["kr"][2::9] = 0.04, 0.04
    return [sky]


def _large_ball(m: Maker) -> Array:
    return m.objects("SPHERE", 1, center=(0, 0, 0), radius=2)


def _mirrored(m: Maker) -> list[Batch]:
    scenes = (_large_ball(m), cloud(m, 6))
    return [m.steady(mirrors(m, each, 120), "it.position", 0.02) for each in scenes]


def _deep(m: Maker) -> list[Batch]:
    deep = mirrors(m, _large_ball(m), 60)
    deep.args["in"]["depth"] = np.choose(np.arange(deep.count) % 4, (0, 12, 3, 6))
    return [deep]


def _alone(m: Maker) -> list[Batch]:
    """Return mirrors that have a colour of their own, in the light."""
    batch = mirrors(m, _large_ball(m), 90, kd=m.uniform(0.2, 0.7, 1, 3)[0], shininess=5)
    lamp = m.lights(-batch.args["it"]["normal"][:1] * np.float32(-60), (1, 1, 1))
    batch.args["it"]["normal"][3::5] *= -1  # seen from behind
    return [replace(batch, globals={**batch.globals, "lights": lamp})]


def _colored(m: Maker) -> list[Batch]:
    """Return mirrors that reflect some channels more than others."""
    coefficient = m.uniform(0.1, 0.9, 1, 3)[0]
    without_red = coefficient * floats([0, 1, 1])
    return [mirrors(m, _large_ball(m), 60, ks=each, kr=each) for each in (coefficient, without_red)]


def _bright(m: Maker) -> list[Batch]:
    """Return mirrors in which something of more than full colour is seen."""
    sphere = _large_ball(m)
    sphere["mat"]["kd"] = (3, 4, 5)
    return [mirrors(m, sphere, 60)]
