"""TP2: scenes, and the nearest of their objects along a ray."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from grader.authoring.expected.vectors import solids
from grader.authoring.expected.vectors.maker import (
    Maker,
    Question,
    Recipe,
    floats,
    integers,
    norm1,
    only,
    result,
    stack,
)
from grader.checking.expected_data import Array, Batch
from grader.intake.header_numbers import header_number

MANY = 1100  # objects: more than the first scenes of the course had room for


def row_of_spheres(m: Maker, order: list[int]) -> Array:
    """Return three unit spheres behind one another along z, at z = -4, 0, 4, in an order."""
    made = m.objects("SPHERE", 3, center=(0, 0, 0), radius=1)
    made["center"][:, 2] = (-4, 0, 4)
    return made[order]


def cloud(m: Maker, count: int, planes: int = 0) -> Array:
    """Return spheres drawn in a box, and planes below and beside it."""
    made = m.objects("SPHERE", count, center=m.uniform(-3, 3, count, 3))
    made["radius"] = m.uniform(0.3, 1.2, count)
    # Dim mirrors: whether the depth may reach its limit or not shows in no picture.
    made["mat"]["ks"] *= 0.4
    made["mat"]["kr"] *= 0.4
    flat = m.objects("PLANE", planes, normal=(0, 1, 0), dist=4)
    flat["normal"][1:] = norm1((1, 0.2, -1))
    flat["dist"][1:] = 6
    return stack(made[: count // 2], flat, made[count // 2 :])


def between(m: Maker, scene: Array) -> Array:
    """Return a scene with an object at either end of the list that no ray meets."""
    away = m.objects("SPHERE", 2, center=[(900, 0, 0), (0, 900, 0)], radius=0.1)
    return stack(away[:1], scene, away[1:])


def towards(m: Maker, scene: Array, count: int) -> Array:
    """Return rays from around the scene towards its spheres."""
    near = (scene["type"] == header_number("SPHERE")) & (np.abs(scene["center"]).max(axis=1) < 100)
    target = scene["center"][near][m.rng.integers(near.sum(), size=count)]
    target = target + m.uniform(-1, 1, count, 3)
    start = m.unit(count) * m.uniform(8, 12, count, 1)
    return m.rays(start, norm1(target - start))


def search(m: Maker, scene: Array, rays: Array, **settings: Array) -> Batch:
    """Return rays through a scene whose answer is clear."""
    args = {"r": rays, "it": m.blank("intersection", len(rays))}
    world = {**m.world(scene, shading=False), **settings}
    batch = Batch("intersect_scene", args, world)
    return m.steady(batch, "r.orig") if len(scene) else batch


def recipes() -> list[Recipe]:
    """Return how the suites of intersect_scene are made."""
    suites = {
        "nearest": _nearest,
        "meets": _meets,
        "every": _every,
        "kinds": _kinds,
        "range": _ranges,
        "count": _counted,
        "nothing": _nothing,
    }
    return [
        Recipe(f"intersect_scene.{name}", partial(_searched, make), *solids.EXACTNESS)
        for name, make in suites.items()
    ]


def _searched(make: Callable[[Maker], list[Batch]], m: Maker) -> list[Question]:
    return [Question(each) for each in make(m) if each.count]


def _along_z(m: Maker) -> Array:
    return m.rays([(0, 0, 9), (0, 0, -9), (0, 0, 2)], [(0, 0, -1), (0, 0, 1), (0, 0, -1)])


def _drawn(m: Maker, count: int) -> list[Batch]:
    """Return rays towards the spheres of scenes of several sizes."""
    clouds = [between(m, cloud(m, size)) for size in (4, 9, 16)]
    return [search(m, scene, towards(m, scene, count)) for scene in clouds]


def _nearest(m: Maker) -> list[Batch]:
    orders = ([0, 1, 2], [2, 1, 0])
    scenes = [between(m, row_of_spheres(m, order)) for order in orders]
    rows = [search(m, scene, _along_z(m)) for scene in scenes]
    hits = [only(each, result(m.ask(each))) for each in rows + _drawn(m, 60)]
    for each in hits[2:]:  # in a range that holds the nearest hit
        first = m.ask(each).answers[0].out["r"]["tmax"]
        each.args["r"][:] = m.used(each.args["r"], 0, first, first)
    return hits


def _meets(m: Maker) -> list[Batch]:
    aside = m.rays([(0, 5, 9), (0, 0, 9)], [(0, 0, -1), (0, 0, 1)])
    single = between(m, m.objects("SPHERE", 1, center=(0, 0, 0), radius=1))
    return [search(m, single, stack(_along_z(m)[:1], aside)), *_drawn(m, 30)]


def _every(m: Maker) -> list[Batch]:
    """Return scenes of one sphere, of a row of which each is met, both ends too, and of many."""
    single = m.objects("SPHERE", 1, center=(0, 0, 0), radius=1)
    row = m.objects("SPHERE", 7, radius=0.8)
    row["center"][:, 0] = np.arange(-6, 7, 2)
    down = m.rays(row["center"] + floats([0.1, 5, 0.2]), (0, -1, 0))
    down["depth"] = 12  # who looks takes no notice of max_depth
    far = np.repeat(row[:1], MANY)
    far["center"] = 900
    return [
        search(m, single, _along_z(m)[:1]),
        *(search(m, each, down) for each in (row[:2], row)),
        search(m, stack(far, row), down),
    ]


def _kinds(m: Maker) -> list[Batch]:
    """Return scenes of all the kinds, some of them of glass, in one order and in the other."""
    made = []
    for planes in (1, 2):
        tall = [standing(m, kind, 2) for kind in ("CYLINDER", "CONE")]
        scene = stack(cloud(m, 3, planes=planes), *tall)
        scene["mat"]["refraction_index"][::3] = 1.5
        for turned in (between(m, scene), between(m, scene[::-1])):
            target = np.where((turned["type"] >= 3)[:, None], turned["base"], turned["center"])
            target = target[np.abs(target).max(axis=1) < 100]
            target = target[m.rng.integers(len(target), size=60)] + m.uniform(-1, 1, 60, 3)
            start = m.unit(60) * m.uniform(8, 12, 60, 1)
            way = norm1(target - start)
            way[::2] *= 2
            made.append(search(m, turned, m.rays(start, way)))
    return made


def standing(m: Maker, kind: str, count: int) -> Array:
    """Return cylinders or cones drawn in a box."""
    made = m.objects(kind, count, base=m.uniform(-3, 3, count, 3), axis=m.unit(count))
    made["length"], made["radius"] = m.uniform(1, 3, count), m.uniform(0.5, 1.2, count)
    return made


def _ranges(m: Maker) -> list[Batch]:
    """Return rays that end before the nearest hit, behind it, or begin there."""
    made = []
    for each in _drawn(m, 60):
        hits = only(each, result(m.ask(each)))
        first = m.ask(hits).answers[0].out["r"]["tmax"]
        turn = np.arange(hits.count) % 4
        ends = [(0 * first, first * 0.6), (first * 0.5, first * 1.3)]
        ends += [(first + 0.1, first + 1000), (first + 50, first + 400)]
        for k, (low, high) in enumerate(ends):
            own = turn == k
            hits.args["r"]["tmin"][own], hits.args["r"]["tmax"][own] = low[own], high[own]
        made.append(m.steady(hits, "r.orig"))
    return made


def _counted(m: Maker) -> list[Batch]:
    """Return scenes that were larger before: more stands in scene[] than counts."""
    made = []
    for count in (1, 3):
        scene = row_of_spheres(m, [1, 0, 2])
        scene["center"][1:, 0] = (-4, 4)
        beyond = scene[:count].copy()
        beyond["center"] += floats([0, 6, 0])
        rays = stack(_along_z(m)[:1], m.rays(beyond["center"] + floats([0, 0, 9]), (0, 0, -1)))
        large = stack(scene[:count], beyond)
        args = {"r": rays, "it": m.blank("intersection", len(rays))}
        world = {**m.world(large, shading=False), "object_count": integers(count)}
        made.append(Batch("intersect_scene", args, world))
    return made


def _nothing(m: Maker) -> list[Batch]:
    meets = _meets(m)
    # Last, and along rays that would meet what a larger scene has left behind in scene[0].
    left = towards(m, meets[-1].globals["scene"], 9)
    empty = search(m, m.core.zeros("object", 0), stack(_along_z(m), left))
    return [*[only(each, ~result(m.ask(each))) for each in meets], empty]
