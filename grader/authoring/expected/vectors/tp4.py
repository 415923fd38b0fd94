"""TP4: shadows, mirrors, the octree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from grader.authoring.expected.vectors import solids, tp2
from grader.authoring.expected.vectors.maker import (
    Maker,
    Question,
    Suite,
    floats,
    norm1,
    only,
    result,
    stack,
)
from grader.authoring.expected.vectors.tp2 import COLOR, COLOR_REASON, EXACT_ENOUGH
from grader.checking.expected_data import Array, Batch

CASES = 120
REASON = "a unit vector: a few float operations"
YES_OR_NO = "the answer is yes or no"
TALL = ("CYLINDER", "CONE")


def suites(m: Maker) -> list[Suite]:
    """Return the suites of TP4."""
    return [*_shadows(m), *_reflected(m), *_mirrors(m), *_octree(m)]


# ---- Shadows ------------------------------------------------------------------------------------


def _barred(m: Maker, scene: Array, position: Array, light: Array, normal: Array) -> Batch:
    hits = m.hits(position, normal, m.materials(len(position)))
    lights = m.lights(light, (1, 1, 1))
    return Batch("in_shadow", {"it": hits, "from": lights}, m.world(scene))


def _shadows(m: Maker) -> list[Suite]:
    ball = m.objects("SPHERE", 1, center=(0, 0, 0), radius=1)
    plain = _barred(
        m,
        ball,
        floats([(0, -3, 0), (3, 0, 0), (0, -3, 0), (0, 3, 0)]),
        floats([(0, 3, 0), (3, 5, 0), (5, -3, 0), (0, -3, 0)]),
        floats([0, 1, 0]),
    )
    cloud = tp2.cloud(m, 9)
    start = m.unit(CASES) * 6
    light = np.asarray(-start + m.uniform(-4, 4, CASES, 3), np.float32)
    drawn = _barred(m, cloud, start, light, norm1(light - start))
    drawn = m.steady(m.steady(drawn, "it.position", 0.05), "from.position", 0.05)
    made = {
        "blocked": [plain, drawn, _close(m)],
        "beyond": [_in_between(m, ball, 1)],
        "behind": [_in_between(m, ball, -1)],
        "own": _own(m),
    }
    made["at_light"] = [_at_light(m, ball)]
    suites = [_suite("in_shadow", name, batches, 0.0, YES_OR_NO) for name, batches in made.items()]
    return [*suites, _used(m, ball)]


def _close(m: Maker) -> Batch:
    """Return points that a small sphere nearly touches, on their way to the light."""
    light = floats([(0, 3, 0), (4, 0, 0), (0, 0, -5)])
    small = m.objects("SPHERE", 3, center=norm1(light) * np.float32(0.03), radius=0.01)
    return _barred(m, small, np.zeros((3, 3), np.float32), light, norm1(light))


def _in_between(m: Maker, ball: Array, side: int) -> Batch:
    """Return a light and a point on the same side of one sphere: nothing lies between.

    With side 1 the sphere is beyond the light, with -1 it is behind the point.
    """
    count = 40
    away = m.unit(count)
    away[0] = (0, 1, 0)
    near, far = away * m.uniform(1.3, 2, count, 1), away * m.uniform(3, 6, count, 1)
    near[0], far[0] = (0, 2, 0), (0, 4, 0)
    start, light = (far, near) if side == 1 else (near, far)
    return _barred(m, ball, start, light, norm1(light - start))


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


def _at_light(m: Maker, ball: Array) -> Batch:
    place = floats([(0, 2, 0), (3, 0, 0), (0, 0, -4)])
    return _barred(m, ball, place, place, floats([0, 1, 0]))


def _used(m: Maker, ball: Array) -> Suite:
    """Return direct_light under a sphere: of two lights, one or both are behind it."""
    position = floats([(0, -3, 0), (4, -3, 0), (8, -3, 0), (-4, -3, 0)])
    lights = m.lights([(0, 5, 0), (-8, 5, 0)], [(1, 1, 1), (0.6, 0.5, 0.4)])
    mat = m.materials(4)
    hits = m.hits(position, (0, 1, 0), mat)
    hits["position"][2:] += m.uniform(-0.2, 0.2, 2, 3)
    v = np.tile(floats([0, 1, 0]), (4, 1))
    batch = Batch("direct_light", {"it": hits, "v": v}, m.world(ball, lights, fresnel=False))
    on = replace(batch, globals=m.world(ball, lights, fresnel=True))
    return Suite("in_shadow.used", (Question(batch, (on,)),), COLOR, COLOR_REASON)


# ---- Mirrors ------------------------------------------------------------------------------------


def arriving(m: Maker, count: int, low: float = 0.1) -> tuple[Array, Array]:
    """Return unit normals, and unit directions that arrive on their side; the first are plain."""
    normal = m.unit(count)
    normal[:2] = (0, 1, 0)
    direction = -m.around(normal, low, 0.95)
    direction[:2] = norm1([(0, -1, 0), (0.6, -0.8, 0)])
    return normal, direction


def _reflected(m: Maker) -> list[Suite]:
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
    args = {"out": m.blank("ray", CASES), "in": rays, "it": hits}
    long = rays.copy()
    long["dir"] *= m.uniform(0.2, 5, CASES, 1)
    long["dir"][:2] = 2 * direction[:2]
    # What the ray that arrives has seen must not bound the one that leaves.
    rays["tmax"] = distance[:, 0]
    unit = Batch("reflected_ray", args, m.world())
    scaled = replace(unit, args={**args, "in": long})
    return [
        _suite("reflected_ray", "unit", [unit], EXACT_ENOUGH, REASON),
        _suite("reflected_ray", "scaled", [scaled], EXACT_ENOUGH, REASON),
    ]


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


def _mirrors(m: Maker) -> list[Suite]:
    nothing = m.core.zeros("object", 0)
    sky = mirrors(m, nothing, 60)
    sky.args["it"]["mat"]["ks"][0] = 1
    balls = [m.objects("SPHERE", 1, center=(0, 0, 0), radius=2), tp2.cloud(m, 6)]
    scenes = [m.steady(mirrors(m, each, 60), "it.position", 0.02) for each in balls]
    deep = mirrors(m, balls[0], 40)
    deep.args["in"]["depth"] = np.choose(np.arange(deep.count) % 4, (0, 12, 5, 10))
    # Fresnel stands for ks in the last variant: whoever has done TP5.2 and ignores the option.
    fresnel_on = [staged(m, each, on=True) for each in (sky, *scenes, deep)]
    plain = [staged(m, each) for each in (sky, *scenes, deep)]
    both = [
        Question(one.batch, (*one.variants, on.batch, *on.variants))
        for one, on in zip(plain, fresnel_on, strict=True)
    ]
    named = {"sky": both[:1], "object": both[1:3], "depth": both[3:]}
    return [Suite(f"mirror_color.{k}", tuple(v), COLOR, COLOR_REASON) for k, v in named.items()]


# ---- The octree ---------------------------------------------------------------------------------


def _octree(m: Maker) -> list[Suite]:
    scenes = [m.objects("SPHERE", 1, center=(0, 0, 0), radius=1), tp2.cloud(m, 30), _crowd(m)]
    made = []
    simple = m.rays([(0, 0, 5), (0, 9, 0)], [(0, 0, -1), (0, 0, 1)])
    for scene in scenes:
        args = {"r": stack(simple, tp2.towards(m, scene, 160))}
        args["it"] = m.blank("intersection", 162)
        batch = Batch("intersect_scene", args, m.world(scene, octree=True))
        made.append(m.steady(batch, "r.orig"))
    hits = [only(each, result(m.ask(each))) for each in [*made, _each(m.aside(), scenes[-1])]]
    flat = tp2.cloud(m, 6, planes=2)
    down = m.rays(floats([(20, 0, 20), (30, 3, 0)]), floats([0, -1, 0]))
    aside = {"r": down, "it": m.blank("intersection", 2)}
    planes = Batch("intersect_scene", aside, m.world(flat[flat["type"] == 1], octree=True))
    planes = replace(planes, globals=m.world(flat, octree=True), answers=m.ask(planes).answers)
    return [
        _suite("octree", "hits", hits, *_SOLID),
        _suite(
            "octree", "misses", [only(each, ~result(m.ask(each))) for each in made[1:]], *_SOLID
        ),
        _suite("octree", "planes", [planes], *_SOLID),
        _suite("octree", "overlap", [_overlaps(m)], 0.0, YES_OR_NO),
        _suite("octree", "tall", [_reaching(m.aside(), kind) for kind in TALL], 0.0, YES_OR_NO),
    ]


_SOLID = (solids.TOLERANCE, solids.REASON)


def _crowd(m: Maker) -> Array:
    """Many small spheres, large ones around and behind a part of them, and one far away."""
    made = m.objects("SPHERE", 200, center=m.uniform(-3, 3, 200, 3))
    made["radius"] = m.uniform(0.08, 0.25, 200)
    made["radius"][7::40] = 1.5
    made["center"][11] = (30, 2, 1)
    return made


def _each(m: Maker, scene: Array) -> Batch:
    """Return a ray for each sphere, from near by: one that stands alone in its box counts too."""
    away = m.unit(len(scene))
    start = scene["center"] + (scene["radius"][:, None] + m.uniform(0.2, 1, len(scene), 1)) * away
    args = {"r": m.rays(start, -away), "it": m.blank("intersection", len(scene))}
    return m.steady(Batch("intersect_scene", args, m.world(scene, octree=True)), "r.orig")


def _overlaps(m: Maker) -> Batch:
    """Spheres that are clearly in a box, or reach into it, or are far; and planes, in none."""
    count = 90
    boxes = m.core.zeros("box", count)
    corner, sides = m.uniform(-3, 3, count, 3), m.uniform(0.5, 3, count, 3)
    corner[:3], sides[:3] = 0, 1
    boxes["min"], boxes["max"] = corner, corner + sides
    objects = m.objects("SPHERE", count, radius=m.uniform(0.1, 1, count))
    objects["radius"][:3] = (0.25, 1, 1)
    inside = corner + sides * m.uniform(0, 1, count, 3)
    away = corner + sides / 2 + m.unit(count) * m.uniform(9, 15, count, 1)
    objects["center"] = np.where(np.arange(count)[:, None] % 2, away, inside)
    # The centre is outside, above one face, and half of the radius reaches in.
    beside, axis = np.arange(4, count, 4), np.arange(4, count, 4) // 4 % 3
    reach = (corner + sides)[beside, axis] + objects["radius"][beside] / 2
    objects["center"][beside, axis] = reach
    objects["center"][:3] = [(0.5, 0.5, 0.5), (20, 0, 0), (0.5, 0.5, 1.5)]
    planes = m.objects("PLANE", 6, normal=(0, 1, 0), dist=m.uniform(-1, 1, 6))
    return Batch(
        "box_overlaps_object",
        {"b": stack(boxes, boxes[:6]), "obj": stack(objects, planes)},
        {},
    )


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


def _suite(function: str, name: str, batches: list[Batch], tolerance: float, reason: str) -> Suite:
    questions = tuple(Question(each) for each in batches if each.count)
    return Suite(f"{function}.{name}", questions, tolerance, reason)
