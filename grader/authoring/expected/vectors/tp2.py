"""TP2: rays of the camera, intersections, colours along a ray."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from grader.authoring.expected.vectors import kinds, solids
from grader.authoring.expected.vectors.bounces import clear
from grader.authoring.expected.vectors.maker import (
    Maker,
    Question,
    Recipe,
    floats,
    norm1,
    only,
    result,
    stack,
)
from grader.authoring.expected.vectors.scenes import cloud, row_of_spheres, search, towards
from grader.authoring.expected.vectors.solids import Solid
from grader.checking.expected_data import SIZE, Array, Batch

EXACT_ENOUGH = 2e-4
LIMIT = 10  # options.max_depth
NEAR = 6e-3  # to what a ray meets: beyond any start of its range that keeps it off its own origin
DIM = 0.95  # of a channel: not limited by who limits colours to 1
COLOR = 2e-3
COLOR_REASON = "float and double differ by less in the last bits of a direction times a lobe"
Shapes = Mapping[str, Callable[[Solid], Batch | list[Batch]]]
COPIED = "a colour is copied, or a few float operations away"


def recipes() -> list[Recipe]:
    """Return how the suites of TP2 are made."""
    return [*_camera(), *_solids(), *_traced()]


# ---- The camera ---------------------------------------------------------------------------------


def _camera() -> list[Recipe]:
    reason = "a unit vector: a few float operations"
    return [
        Recipe(f"camera_ray.{name}", partial(_through, name), EXACT_ENOUGH, reason)
        for name in ("middle", "horizontal", "vertical", "anywhere")
    ]


def _through(name: str, m: Maker) -> list[Question]:
    """Return positions along a line of the image, or all over it."""
    count = {"middle": 1, "anywhere": 63}.get(name, 23)
    turns = name in ("horizontal", "anywhere"), name in ("vertical", "anywhere")
    x, y = (
        _ends(m, count, size) if turned else floats([size / 2] * count)
        for size, turned in zip(SIZE, turns, strict=True)
    )
    args = {"r": m.blank("ray", count), "x": x, "y": y}
    return [
        Question(Batch("camera_ray", args, {**m.world(), "theCamera": each}))
        for each in _cameras(m)
    ]


def _ends(m: Maker, count: int, size: int) -> Array:
    ends = floats([0, size, size / 4])
    return stack(ends, m.uniform(0, size, count - len(ends)))


def _cameras(m: Maker) -> list[Array]:
    aspect = SIZE[0] / SIZE[1]
    drawn = [m.uniform(-3, 3, 3) for _ in range(4)]
    return [
        m.camera((0, 0, 2), (0, 0, 0), 90, aspect),
        m.camera((2, 1, 3), (0, 0.3, 0), 60, aspect),
        m.camera(drawn[0], drawn[1], 40, 2.0),
        m.camera(drawn[2], drawn[3], 100, 0.75),
    ]


# ---- One object ---------------------------------------------------------------------------------


def _solids() -> list[Recipe]:
    closed: Shapes = {"inside": Solid.inside, "caps": lambda solid: [_caps(solid), _out(solid)]}
    types: Mapping[str, tuple[Callable[[Maker], Solid], Shapes]] = {
        "sphere": (kinds.spheres, {"inside": Solid.inside, "meets": _specks_too}),
        "plane": (kinds.planes, {"parallel": _parallel, "grazing": kinds.grazing}),
        "cylinder": (kinds.cylinders, closed),
        "cone": (kinds.cones, closed),
    }
    return [
        solids.recipe(solid, f"intersect_{kind}", name, make)
        for kind, (solid, others) in types.items()
        for name, make in {**solids.EVERY, **others}.items()
    ]


def _specks_too(solid: Solid) -> list[Batch]:
    """Rays that hit spheres or pass by, and some towards very small ones, which count as well."""
    m, count = solid.m, 24
    specks = m.objects("SPHERE", count, center=m.uniform(-2, 2, count, 3))
    specks["radius"] = m.uniform(0.02, 0.06, count)
    away = m.unit(count) * m.uniform(2, 4, count, 1)
    args = {"r": m.rays(specks["center"] + away, norm1(-away)), "obj": specks}
    return [solid.meets(), solid.hits(args)]


def _caps(solid: Solid) -> Batch:
    """Rays that meet a disc at an end, from outside."""
    m, objects = solid.m, solid.objects
    target = solid.near(objects, 0.8)
    outwards = -objects["axis"].copy()
    if solid.function == "intersect_cylinder":
        outwards[::2] *= -1
    away = m.around(outwards, 0.8) * m.uniform(4, 9, len(target), 1)
    simple = solid.simple["r"][[2, 4]]
    rays = stack(simple, m.rays(target + away, norm1(-away)))
    batch = solid.hits({"r": rays, "obj": stack(solid.simple["obj"][:2], objects)})
    normal = m.ask(batch).answers[0].out["it"]["normal"]
    along = np.abs(np.einsum("ij,ij->i", normal, batch.args["obj"]["axis"]))
    return only(batch, along > 0.999)


def _out(solid: Solid) -> Batch:
    """Rays that start inside and leave through a disc."""
    m, objects = solid.m, solid.objects
    outwards = -objects["axis"].copy()
    if solid.function == "intersect_cylinder":
        outwards[::2] *= -1
    rays = m.rays(solid.near(objects, 0.5), m.around(outwards, 0.8))
    batch = solid.hits({"r": rays, "obj": objects})
    normal = m.ask(batch).answers[0].out["it"]["normal"]
    along = np.abs(np.einsum("ij,ij->i", normal, batch.args["obj"]["axis"]))
    return only(batch, along > 0.999)


def _parallel(solid: Solid) -> Batch:
    """Rays along the plane: above it, below it, and in it."""
    m = solid.m
    objects = m.objects("PLANE", 9, normal=(0, 1, 0), dist=0)
    objects["normal"][3:6], objects["normal"][6:] = (1, 0, 0), (0, 0, 1)
    objects["dist"] = np.tile([1, 2, 0], 3)
    ways = np.roll(objects["normal"], 1, axis=1)
    rays = m.rays(np.zeros((9, 3)), ways)
    rays["tmin"][::2] = 0.5
    return solid.batch({"r": rays, "obj": objects})


# ---- Colours ------------------------------------------------------------------------------------


def lit(m: Maker, scene: Array, **changed: bool) -> dict[str, Array]:
    """Return the globals of a scene with two lights."""
    lights = m.lights([(5, 9, 7), (-8, 6, 2)], [(1, 1, 1), (0.4, 0.5, 0.6)])
    return m.world(scene, lights, **changed)


def _traced() -> list[Recipe]:
    suites = {
        "object": _colors,
        "sky": _skies,
        "depth": _deep,
        "lit": _lit,
        "pattern": _patterned,
        "bright": _bright,
    }
    made = [
        Recipe(f"trace_ray.{k}", partial(_clear, make), COLOR, COLOR_REASON)
        for k, make in suites.items()
    ]
    return [*made, Recipe("raytrace", lambda m: [_picture(m)], COLOR, COPIED)]


def _clear(make: Callable[[Maker], list[Question]], m: Maker) -> list[Question]:
    return [clear(m, each, COLOR / 4) for each in make(m)]


def _seen(m: Maker) -> list[tuple[Batch, Batch]]:
    """Return calls of trace_ray in several scenes: those that meet an object, and the others."""
    simple = m.rays([(0, 0, 9)], [(0, 0, -1)])
    first = (row_of_spheres(m, [0, 1, 2]), simple)
    scenes = [
        first,
        *((s, towards(m, s, 40)) for s in (cloud(m, 5), cloud(m, 9))),
    ]
    made = []
    for scene, rays in scenes:
        batch = search(m, scene, stack(rays, m.rays([(0, 20, 9)], [(0, 0, -1)])))
        hit = result(m.ask(batch))
        found, lost = batch.args["r"][hit], batch.args["r"][~hit]
        batch = Batch("trace_ray", {"r": found}, lit(m, scene))
        made.append((batch, replace(batch, args={"r": lost})))
    return made


def _colors(m: Maker) -> list[Question]:
    return [_to_the_limit(m, found) for found, _ in _seen(m)]


def _skies(m: Maker) -> list[Question]:
    lost = [lost for _, lost in _seen(m)]
    empty = replace(lost[0], globals=lit(m, m.core.zeros("object", 0)))
    for each in (*lost, empty):  # a mirror sees the sky as well
        each.args["r"]["depth"] = np.arange(each.count) % 4
    return [m.stages(each) for each in (*lost, empty)]


def _deep(m: Maker) -> list[Question]:
    """Return rays that have bounced often, then too often.

    Of those that have bounced too often, some would meet nothing.
    """
    made = []
    for found, lost in _seen(m):
        for depths in ((0, 2, 4, 6, 8), (11, 12)):
            deep = stack(found.args["r"], *([lost.args["r"]] if max(depths) > LIMIT else []))
            deep["depth"][: found.count] = np.resize(depths, found.count)
            deep["depth"][found.count :] = depths[-1]
            made.append(_to_the_limit(m, replace(found, args={"r": deep})))
    return made


def _lit(m: Maker) -> list[Question]:
    """Return rays of several depths and ranges in scenes with lights and mirrors."""
    made = []
    for count in (3, 6):
        scene = cloud(m, count, planes=2)
        scene["mat"]["ks"][::2] = (0.9, 0.8, 0.7)
        scene["mat"]["kr"][::2] = (0.9, 0.8, 0.7)
        batch = search(m, scene, towards(m, scene, 60))
        rays = batch.args["r"].copy()
        first = m.ask(batch).answers[0].out["r"]["tmax"]
        turn = np.arange(len(rays)) % 5
        rays["orig"][turn == 0] += (rays["dir"] * (first - NEAR)[:, None])[turn == 0]
        rays["depth"] = np.choose(turn, (0, 1, 0, 9, 2))
        rays["tmax"] = np.where(turn == 2, first * 0.7, 1000)
        batch = m.ask(Batch("trace_ray", {"r": rays}, lit(m, scene, octree=True)))
        made.append(Question(only(replace(batch, answers=()), result(batch).max(axis=1) < DIM)))
    return made


def _bright(m: Maker) -> list[Question]:
    """Return rays that meet objects of more than full colour."""
    found = _seen(m)[1][0]
    found.globals["scene"]["mat"]["kd"] *= 4
    return [m.stages(found)]


def _patterned(m: Maker) -> list[Question]:
    """Return rays that meet objects with a pattern, without lights."""
    scene = cloud(m, 5, planes=2)
    scene["mat"]["pattern"] = int(m.core.constants["PATTERN_CHECKER"])
    batch = search(m, scene, towards(m, scene, 60))
    hits = only(batch, result(m.ask(batch)))
    return [m.stages(Batch("trace_ray", {"r": hits.args["r"]}, lit(m, scene)))]


def _to_the_limit(m: Maker, batch: Batch) -> Question:
    """Return the calls at every stage; those that stop at max_depth itself are accepted too."""
    question = m.stages(batch)
    sooner = [
        replace(each, globals={**each.globals, "options": _stopping_at(each.globals["options"])})
        for each in question.variants
    ]
    return Question(question.batch, (*question.variants, *sooner))


def _stopping_at(options: Array) -> Array:
    changed = options.copy()
    changed["max_depth"] -= 1
    return changed


def _picture(m: Maker) -> Question:
    """Return the setting of a picture, and the positions at which it is compared."""
    width, height = SIZE
    scene = m.objects("SPHERE", 3, radius=0.7)
    scene["center"] = [(0, 0, 0), (1.5, 0.5, 0), (-1, -1, 1)]
    camera = m.camera((0, 0, 4), (0, 0, 0), 60, width / height)
    i, j = m.rng.integers(0, width, 400), m.rng.integers(0, height, 400)
    args = {"r": m.blank("ray", 400), "x": i + np.float32(0.5), "y": j + np.float32(0.5)}
    settings = m.world(scene, shading=False)
    return Question(Batch("camera_ray", args, {**settings, "theCamera": camera}))
