"""TP5, bonus: glass."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from grader.authoring.expected.vectors.maker import Maker, Question, Recipe, floats, only, stack
from grader.authoring.expected.vectors.mirrors import arriving
from grader.authoring.expected.vectors.tp2 import COLOR
from grader.authoring.expected.vectors.tp5 import CASES, REASON
from grader.checking.expected_data import Array, Batch

DRAWS = 400  # of glass_color for each angle


def _refracted(m: Maker, normal: Array, direction: Array) -> Batch:
    count = len(normal)
    position = m.uniform(-3, 3, count, 3)
    position[:2] = 0
    mat = m.materials(count, refraction_index=m.uniform(1.1, 2.5, count))
    mat["refraction_index"][:2] = 1.5
    rays = m.rays(position - direction, direction, depth=m.rng.integers(0, 9, count))
    rays["tmin"], rays["tmax"] = m.uniform(0.2, 0.9, count), 1
    rays["seed"] = m.rng.integers(2, 1 << 32, count, dtype=np.uint32)
    hits = m.hits(position, normal, mat)
    return Batch("refracted_ray", {"out": m.blank("ray", count), "in": rays, "it": hits}, m.world())


def recipes() -> list[Recipe]:
    """Return how the suites of glass are made."""
    rays = {"entering": _entering, "leaving": _leaving, "total": _total, "scaled": _scaled}
    draws = {"odds": _at_angles, "plain": _by_ks, "total": _beyond_the_limit, "twice": _two_panes}
    return [
        *(
            Recipe(f"refracted_ray.{name}", partial(_asked, make), 1e-3, REASON)
            for name, make in rays.items()
        ),
        *(
            Recipe(f"glass_color.{name}", make, COLOR, "a share of random draws")
            for name, make in draws.items()
        ),
    ]


def _asked(make: Callable[[Maker], Batch], m: Maker) -> list[Question]:
    return [Question(make(m))]


def _entering(m: Maker) -> Batch:
    """Return rays that enter, some of them what is thinner than the outside."""
    normal, direction = arriving(m, CASES, 0.05)
    batch = _refracted(m, normal, direction)
    thin = np.arange(CASES) % 8 == 7
    batch.args["it"]["mat"]["refraction_index"][thin] = 0.8
    sine2 = 1 - np.einsum("ij,ij->i", normal, direction) ** 2
    return only(batch, ~thin | (1 - sine2 / 0.8**2 > LIMIT))


def _scaled(m: Maker) -> Batch:
    """Return rays that enter with directions that are not unit."""
    batch = _entering(m)
    batch.args["in"]["dir"] *= m.uniform(0.3, 4, batch.count, 1)
    return batch


def _outwards(m: Maker) -> tuple[Batch, Array]:
    """Return rays from inside, and what stands under the root for each."""
    normal, _ = arriving(m, CASES, 0.05)
    outwards = m.around(normal, 0.05, 0.98)
    outwards[0] = normal[0]
    batch = _refracted(m, normal, outwards)
    batch.args["it"]["mat"]["refraction_index"][2:] = m.uniform(1.05, 1.8, CASES - 2)
    sine2 = 1 - np.einsum("ij,ij->i", normal, outwards) ** 2
    return batch, 1 - batch.args["it"]["mat"]["refraction_index"] ** 2 * sine2


def _leaving(m: Maker) -> Batch:
    batch, under_root = _outwards(m)
    return only(batch, under_root > LIMIT)


def _total(m: Maker) -> Batch:
    batch, under_root = _outwards(m)
    return only(batch, under_root < -LIMIT)


LIMIT = 0.02  # nearer to the limit of total reflection, rounding decides

# Cosine of the angle, index: the share that is reflected is about 4, 21, 35 and 61 %; then diamond:
# there the index makes the share, where elsewhere the angle does.
ANGLES = ((1.0, 1.5), (0.3, 1.5), (0.2, 1.3), (0.1, 1.5), (1.0, 2.5))


def _at_angles(m: Maker) -> list[Question]:
    outside = [_drawn(m, cosine, index) for cosine, index in ANGLES]
    inside = [_drawn(m, *each, inside=True) for each in ((0.9, 1.5), (0.25, 1.02))]
    return [*outside, *inside]


def _by_ks(m: Maker) -> list[Question]:
    return [_drawn(m, 0.1, 1.5, ks) for ks in ((1, 0, 0.5), (0, 1, 0.5))]


def _beyond_the_limit(m: Maker) -> list[Question]:
    """Return rays in glass that cannot leave it."""
    return [_drawn(m, cosine, 1.5, inside=True) for cosine in (0.6, 0.3)]


def _two_panes(m: Maker) -> list[Question]:
    """Return rays that meet glass again behind the glass: what they see there is drawn as well."""
    question = _drawn(m, 0.3, 1.5)
    pane = m.objects("PLANE", 1, normal=(0, 1, 0), dist=2)
    pane["mat"] = m.materials(1, kd=0, ks=0, kr=0, refraction_index=1.5)
    floor = question.batch.globals["scene"]
    world = {**m.world(stack(floor, pane)), "lights": m.lights([(0, 50, 0)], [(3, 3, 3)])}
    calls = {name: column[:120] for name, column in question.batch.args.items()}
    return [Question(Batch("glass_color", calls, world))]


def _drawn(
    m: Maker,
    cosine: float,
    index: float,
    ks: tuple[float, float, float] | None = None,
    inside: bool = False,
) -> Question:
    """Return the same ray with many seeds: reflected it sees the sky, refracted a floor.

    With `ks` that is the material's, and Fresnel is off. From `inside` the normal points away.
    """
    floor = m.objects("PLANE", 1, normal=(0, 1, 0), dist=5)
    floor["mat"] = m.materials(1, kd=(0.9, 0.1, 0.1), ks=0, kr=0)
    direction = floats([[np.sqrt(1 - cosine**2), -cosine, 0]])
    rays = m.rays(np.repeat(-direction, DRAWS, axis=0), direction)
    rays["seed"] = m.rng.integers(2, 1 << 32, DRAWS, dtype=np.uint32)
    mat = m.materials(DRAWS, refraction_index=index)
    if ks is not None:
        mat["ks"] = ks
    hits = m.hits((0, 0, 0), (0, -1 if inside else 1, 0), mat)
    world = m.world(floor, shading=False, fresnel=ks is None)
    return Question(Batch("glass_color", {"in": rays, "it": hits}, world))
