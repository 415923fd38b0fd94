"""TP5: Fresnel, samples, glass, the fractal."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from grader.authoring.expected.vectors import tp3, tp4
from grader.authoring.expected.vectors.maker import (
    Maker,
    Question,
    Recipe,
    floats,
    integers,
    norm1,
    only,
    stack,
)
from grader.authoring.expected.vectors.tp2 import COLOR, COLOR_REASON
from grader.checking.expected_data import SIZE, Array, Batch

CASES = 100
TOLERANCE = 1e-4
REASON = "a few float operations; the fifth power may be made by powf"
DRAWS = 400  # of glass_color for each angle


def recipes() -> list[Recipe]:
    """Return how the suites of TP5 are made."""
    return [
        Recipe("reflectance.any", _indices, TOLERANCE, REASON),
        *_schlick(),
        Recipe("fresnel_use.lobe", _in_the_lobe, tp3.TOLERANCE, tp3.REASON),
        Recipe("fresnel_use.mirror", _in_the_mirror, COLOR, COLOR_REASON),
        *_samples(),
        *_glass(),
        Recipe("populate_spheres.any", _fractal, 1e-3, "a few float operations a generation"),
    ]


# ---- Fresnel ------------------------------------------------------------------------------------


def _indices(m: Maker) -> list[Question]:
    simple = floats([(1, 1.5), (1.5, 1), (1, 3), (1.33, 1.33), (2, 1)])
    both = stack(simple, m.uniform(1, 3, 40, 2))
    return [Question(Batch("reflectance", {"n1": both[:, 0], "n2": both[:, 1]}, {}))]


def _schlick() -> list[Recipe]:
    views = {"normal": lambda m, n: n, "grazing": _across, "angle": _aslant, "negative": _behind}
    return [
        Recipe(f"fresnel_schlick.{name}", partial(_viewed, view), TOLERANCE, REASON)
        for name, view in views.items()
    ]


def _viewed(view: Callable[[Maker, Array], Array], m: Maker) -> list[Question]:
    n = m.unit(CASES)
    n[:3] = (0, 1, 0)
    kr = m.uniform(0.02, 0.9, CASES, 3)
    kr[0] = 0.5
    return [Question(Batch("fresnel_schlick", {"kr": kr, "n": n, "v": view(m, n)}, {}))]


def _across(m: Maker, n: Array) -> Array:
    return _starting((1, 0, 0), norm1(np.cross(n, m.unit(len(n)))))


def _aslant(m: Maker, n: Array) -> Array:
    return _starting((0.96, 0.28, 0), m.around(n, 0.05, 0.95))


def _behind(m: Maker, n: Array) -> Array:
    return _starting((0, -1, 0), -m.around(n, 0.1))


def _starting(first: tuple[float, float, float], vectors: Array) -> Array:
    vectors[0] = first
    return vectors


def _in_the_lobe(m: Maker) -> list[Question]:
    n, v, light = tp3.directions(m)
    near = tp3.shading(m, n, v, light)
    args = near.batch.args
    # A wide lobe, so that the coefficient counts in every case.
    args["mat"]["shininess"], args["mat"]["kd"][:2] = m.uniform(1, 9, len(n)), 0
    on = replace(near.batch, globals=m.world(fresnel=True))

    def put(changed: Array) -> dict[str, Array]:
        return {**args, "mat": changed}

    by_normal = tp3.with_fresnel(m, near.batch, args["mat"], n, v, put)[1]
    return [Question(on, (by_normal,))]


def _in_the_mirror(m: Maker) -> list[Question]:
    sky = tp4.mirrors(m, m.core.zeros("object", 0), 60)
    sky.args["it"]["mat"]["kr"][:30] *= 0.1
    return [tp4.staged(m, sky, on=True)]


# ---- Samples ------------------------------------------------------------------------------------


SHARES = [(n, k, upright) for n in (2, 3, 4) for k in range(1, n) for upright in (False, True)]


def _samples() -> list[Recipe]:
    edges = {
        "uniform": ([(2, 0, False), (3, 0, True)], 0.9),
        "mean": ([(1, 0, True), *SHARES], 0.9),
        "clamped": (SHARES, 5.0),
    }
    reason = (
        "a square is 0.05 of contrast at least; a plane seen along itself, where the options are"
        " ignored, mirrors the sky by a share that changes across the pixel"
    )
    return [
        Recipe(f"pixel_color.{name}", partial(_edges, *each), 0.03, reason)
        for name, each in edges.items()
    ]


def _edges(shares: list[tuple[int, int, bool]], red: float, m: Maker) -> list[Question]:
    return [_edge(m, n, k, upright, red) for n, k, upright in shares]


def _edge(m: Maker, samples: int, covered: int, upright: bool, red: float) -> Question:
    """Return pixels cut by the straight edge of a plane that passes just below the eye.

    The plane covers a share `covered` / `samples` of pixel (i, j); the rest is sky.
    """
    width, height = SIZE
    camera = m.camera((0, 0, 0), (0, 0, -1), 90, width / height)
    i, j = int(m.rng.integers(8, width - 8)), int(m.rng.integers(8, height - 8))
    share = covered / samples
    # Where the edge crosses the image plane, along xdir or ydir, with the eye at 1 from it.
    if upright:
        place, along = (i + share - width / 2) / (width / 2), camera["xdir"]
    else:
        place, along = (j + share - height / 2) / (height / 2) / (width / height), camera["ydir"]
    normal = norm1(along - place * camera["zdir"])
    # Lit from above so that it is of about the same colour with shading as without.
    mat = m.materials(1, kd=(red, 0.9, 0.1), ks=0, kr=0, shininess=500)
    plane = m.objects("PLANE", 1, mat, normal=normal, dist=1e-3)
    lamp = m.lights([normal * np.float32(100)], np.pi)
    settings = {**m.world(plane, lamp), "theCamera": camera}
    others = (1, 0) if upright else (0, 1)
    columns = integers([i, i + others[0], i - others[0]])
    rows = integers([j, j + others[1], j - others[1]])
    question = m.stages(Batch("pixel_color", {"i": columns, "j": rows}, settings))
    for each in (question.batch, *question.variants):
        each.globals["options"]["samples"] = samples
    return question


# ---- Glass --------------------------------------------------------------------------------------


def _refracted(m: Maker, normal: Array, direction: Array) -> Batch:
    count = len(normal)
    position = m.uniform(-3, 3, count, 3)
    position[:2] = 0
    mat = m.materials(count, refraction_index=m.uniform(1.1, 2.5, count))
    mat["refraction_index"][:2] = 1.5
    rays = m.rays(position - direction, direction, depth=m.rng.integers(0, 9, count))
    rays["seed"] = m.rng.integers(2, 1 << 32, count, dtype=np.uint32)
    hits = m.hits(position, normal, mat)
    return Batch("refracted_ray", {"out": m.blank("ray", count), "in": rays, "it": hits}, m.world())


def _glass() -> list[Recipe]:
    rays = {"entering": _entering, "leaving": _leaving, "total": _total, "scaled": _scaled}
    draws = {"odds": _at_angles, "plain": _by_ks}
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
    return _refracted(m, *tp4.arriving(m, CASES, 0.05))


def _scaled(m: Maker) -> Batch:
    """Return rays that enter with directions that are not unit."""
    batch = _entering(m)
    batch.args["in"]["dir"] *= m.uniform(0.3, 4, CASES, 1)
    return batch


def _outwards(m: Maker) -> tuple[Batch, Array]:
    """Return rays from inside, and what stands under the root for each."""
    normal, _ = tp4.arriving(m, CASES, 0.05)
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
    return [_drawn(m, cosine, index) for cosine, index in ANGLES]


def _by_ks(m: Maker) -> list[Question]:
    return [_drawn(m, 0.1, 1.5, ks) for ks in ((1, 0, 0.5), (0, 1, 0.5))]


def _drawn(
    m: Maker, cosine: float, index: float, ks: tuple[float, float, float] | None = None
) -> Question:
    """Return the same ray with many seeds: reflected it sees the sky, refracted a floor.

    With `ks` that is the material's, and Fresnel is off.
    """
    floor = m.objects("PLANE", 1, normal=(0, 1, 0), dist=5)
    floor["mat"] = m.materials(1, kd=(0.9, 0.1, 0.1), ks=0, kr=0)
    direction = floats([[np.sqrt(1 - cosine**2), -cosine, 0]])
    rays = m.rays(np.repeat(-direction, DRAWS, axis=0), direction)
    rays["seed"] = m.rng.integers(2, 1 << 32, DRAWS, dtype=np.uint32)
    mat = m.materials(DRAWS, refraction_index=index)
    if ks is not None:
        mat["ks"] = ks
    hits = m.hits((0, 0, 0), (0, 1, 0), mat)
    world = m.world(floor, shading=False, fresnel=ks is None)
    return Question(Batch("glass_color", {"in": rays, "it": hits}, world))


# ---- The fractal --------------------------------------------------------------------------------


def _fractal(m: Maker) -> list[Question]:
    depth = integers([0, 1, 2, 3, 4])
    up = stack(floats([(0, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 0)]), m.unit(1))
    center, radius = m.uniform(-2, 2, 5, 3), m.uniform(0.5, 2, 5)
    center[:3], radius[:3] = 0, 1
    args = {"center": center, "radius": radius, "up": up, "depth": depth}
    return [Question(Batch("populate_spheres", args, m.world()))]
