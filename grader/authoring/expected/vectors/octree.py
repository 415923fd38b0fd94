"""TP4, bonus: the octree."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from grader.authoring.expected.vectors import solids
from grader.authoring.expected.vectors.maker import (
    Maker,
    Recipe,
    floats,
    norm1,
    only,
    result,
    stack,
)
from grader.authoring.expected.vectors.scenes import cloud, standing, towards
from grader.authoring.expected.vectors.tp4 import YES_OR_NO, asked, ball
from grader.checking.expected_data import Array, Batch

FEW = range(4, 13)  # spheres of a scene that a leaf may just hold
TALL = ("CYLINDER", "CONE")


def recipes() -> list[Recipe]:
    """Return how the suites of the octree are made."""
    walks = {"hits": _hits, "misses": _misses, "planes": _planes, "kinds": _kinds}
    boxes = {"overlap": _overlaps, "tall": _reaches}
    exactness = {**dict.fromkeys(walks, solids.EXACTNESS), **dict.fromkeys(boxes, (0.0, YES_OR_NO))}
    return [
        Recipe(f"octree.{name}", partial(asked, make), *exactness[name])
        for name, make in {**walks, **boxes}.items()
    ]


def _searches(m: Maker, scenes: list[Array]) -> list[Batch]:
    """Return rays towards the spheres of scenes, and two plain ones."""
    made = []
    simple = m.rays([(0, 0, 5), (0, 9, 0)], [(0, 0, -1), (0, 0, 1)])
    for scene in scenes:
        rays = m.used(stack(simple, towards(m, scene, 160)), 60, 1, 200)
        args = {"r": rays, "it": m.blank("intersection", 162)}
        batch = Batch("intersect_scene", args, m.world(scene, octree=True))
        made.append(m.steady(batch, "r.orig"))
    return made


def _hits(m: Maker) -> list[Batch]:
    scenes = [ball(m), cloud(m, 30), _heap(m), _crowd(m)]
    # A leaf may be just full: as many spheres as it may hold, whatever that is.
    few = [_each(m, cloud(m, count)) for count in FEW]
    made = [*_searches(m, scenes), _each(m, scenes[-1]), *few]
    return [only(each, result(m.ask(each))) for each in made]


def _misses(m: Maker) -> list[Batch]:
    made = _searches(m, [cloud(m, 30), _crowd(m)])
    return [only(each, ~result(m.ask(each))) for each in made]


def _planes(m: Maker) -> list[Batch]:
    """Return rays that meet a plane, inside the box of all the spheres, and none of these."""
    balls = cloud(m, 6)
    flat = m.objects("PLANE", 1, normal=(0, 1, 0), dist=0)
    across = m.uniform(-2, 2, 200, 3) * floats([1, 0, 1])
    away = m.unit(200) * 6
    args = {"r": m.rays(across + away, norm1(-away)), "it": m.blank("intersection", 200)}
    alone = m.steady(Batch("intersect_scene", args, m.world(balls, octree=True)), "r.orig")
    misses = only(alone, ~result(m.ask(alone)))
    answered = m.ask(misses).answers
    return [replace(misses, globals=m.world(stack(balls, flat), octree=True), answers=answered)]


def _kinds(m: Maker) -> list[Batch]:
    """Return rays towards cylinders and cones that stand among spheres."""
    tall = [standing(m, kind, 8) for kind in TALL]
    scene = stack(cloud(m, 20), *tall)
    target = stack(*(each["base"] for each in tall))
    target = np.repeat(target + 0.3 * stack(*(each["axis"] for each in tall)), 8, axis=0)
    away = m.unit(len(target))
    args = {"r": m.rays(target + 9 * away, -away), "it": m.blank("intersection", len(target))}
    return [m.steady(Batch("intersect_scene", args, m.world(scene, octree=True)), "r.orig")]


def _crowd(m: Maker) -> Array:
    """Many small spheres, large ones around and behind a part of them, and one far away."""
    made = m.objects("SPHERE", 200, center=m.uniform(-3, 3, 200, 3))
    made["radius"] = m.uniform(0.08, 0.25, 200)
    made["radius"][7::40] = 1.5
    made["center"][11] = (30, 2, 1)
    return made


def _heap(m: Maker) -> Array:
    """Spheres that nearly coincide, which no cut tells apart, and two far away.

    A heap that filled the tree's box would have eight times as many boxes at each cut: a tree of
    ten cuts is right, and ends only where the heap is small in it.
    """
    made = m.objects("SPHERE", 40, center=m.uniform(-0.2, 0.2, 40, 3))
    made["radius"] = m.uniform(1, 1.1, 40)
    far = m.objects("SPHERE", 2, center=[(-200, -190, -210), (205, 180, 160)], radius=1)
    return stack(made, far)


def _each(m: Maker, scene: Array) -> Batch:
    """Return a ray for each sphere, from near by: one that stands alone in its box counts too."""
    away = m.unit(len(scene))
    start = scene["center"] + (scene["radius"][:, None] + m.uniform(0.2, 1, len(scene), 1)) * away
    args = {"r": m.rays(start, -away), "it": m.blank("intersection", len(scene))}
    return m.steady(Batch("intersect_scene", args, m.world(scene, octree=True)), "r.orig")


def _overlaps(m: Maker) -> list[Batch]:
    """Spheres that are clearly in a box, or reach into it, or are far; and planes, in none."""
    count = 90
    boxes = m.core.zeros("box", count)
    corner, sides = m.uniform(-3, 3, count, 3), m.uniform(0.5, 3, count, 3)
    corner[:3], sides[:3] = 0, 1
    boxes["min"], boxes["max"] = corner, corner + sides
    objects = m.objects("SPHERE", count, radius=m.uniform(0.1, 1, count))
    objects["radius"][:3] = (0.25, 1, 1)
    inside = corner + sides * m.uniform(0, 1, count, 3)
    along = m.unit(count)
    # Some are far along one axis alone: who forgets that axis takes them for near.
    along[1::4] = np.eye(3)[np.arange(1, count, 4) // 4 % 3]
    away = corner + sides / 2 + along * m.uniform(9, 15, count, 1)
    objects["center"] = np.where(np.arange(count)[:, None] % 2, away, inside)
    # The centre is outside, above one face, and half of the radius reaches in.
    beside, axis = np.arange(4, count, 4), np.arange(4, count, 4) // 4 % 3
    reach = (corner + sides)[beside, axis] + objects["radius"][beside] / 2
    objects["center"][beside, axis] = reach
    objects["center"][:3] = [(0.5, 0.5, 0.5), (20, 0, 0), (0.5, 0.5, 1.5)]
    # One that touches a face, and boxes that lie well inside.
    objects["center"][3], objects["radius"][3] = (2, 0.5, 0.5), 1
    boxes["min"][3], boxes["max"][3] = 0, 1
    objects["radius"][5::8] = 9
    objects["center"][5::8] = corner[5::8] + 1
    planes = m.objects("PLANE", 6, normal=(0, 1, 0), dist=m.uniform(-1, 1, 6))
    args = {"b": stack(boxes, boxes[:6]), "obj": stack(objects, planes)}
    return [Batch("box_overlaps_object", args, {})]


def _reaches(m: Maker) -> list[Batch]:
    return [_reaching(m, kind) for kind in TALL]


def _reaching(m: Maker, kind: str) -> Batch:
    """Boxes around a point that is in a cylinder or a cone: near its rim, its ends or its tip."""
    count = 90
    objects = m.objects(kind, count, base=m.uniform(-3, 3, count, 3), axis=m.unit(count))
    objects["length"], objects["radius"] = m.uniform(0.5, 3, count), m.uniform(0.2, 1.5, count)
    up, out = m.uniform(0.02, 0.98, count), np.full(count, 0.97, np.float32)
    up[::3], up[1::3] = 0.02, 0.98
    aside = norm1(np.cross(objects["axis"], m.unit(count)))
    objects["base"][:2], objects["axis"][:2], aside[:2] = 0, (0, 1, 0), (1, 0, 0)
    objects["length"][:2], objects["radius"][:2] = 2, 1
    if kind == "CONE":
        out *= 1 - up
    along = (up * objects["length"])[:, None] * objects["axis"]
    point = objects["base"] + along + (out * objects["radius"])[:, None] * aside
    boxes = m.core.zeros("box", count)
    boxes["min"] = point - m.uniform(0.02, 0.3, count, 3)
    boxes["max"] = point + m.uniform(0.02, 0.3, count, 3)
    return Batch("box_overlaps_object", {"b": boxes, "obj": objects}, {})
