"""TP2: rays of the camera, intersections, colours along a ray."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from grader.authoring.expected.vectors import solids
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
from grader.authoring.expected.vectors.solids import Solid
from grader.checking.expected_data import SIZE, Array, Batch

EXACT_ENOUGH = 2e-4
COLOR = 2e-3
COLOR_REASON = "float and double differ by less in the last bits of a direction times a lobe"
Shapes = Mapping[str, Callable[[Solid], Batch]]
COPIED = "a colour is copied, or a few float operations away"


def recipes() -> list[Recipe]:
    """Return how the suites of TP2 are made."""
    return [*_camera(), *_solids(), *_scenes(), *_traced()]


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
    closed: Shapes = {"inside": Solid.inside, "caps": _caps}
    kinds: dict[str, tuple[Callable[[Maker], Solid], Shapes]] = {
        "sphere": (solids.spheres, {"inside": Solid.inside}),
        "plane": (solids.planes, {"parallel": _parallel}),
        "cylinder": (solids.cylinders, closed),
        "cone": (solids.cones, closed),
    }
    return [
        solids.recipe(solid, f"intersect_{kind}", name, make)
        for kind, (solid, others) in kinds.items()
        for name, make in {**solids.EVERY, **others}.items()
    ]


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


def _parallel(solid: Solid) -> Batch:
    """Rays along the plane: above it, below it, and in it."""
    m = solid.m
    objects = m.objects("PLANE", 9, normal=(0, 1, 0), dist=0)
    objects["normal"][3:6], objects["normal"][6:] = (1, 0, 0), (0, 0, 1)
    objects["dist"] = np.tile([1, 2, 0], 3)
    ways = np.roll(objects["normal"], 1, axis=1)
    return solid.batch({"r": m.rays(np.zeros((9, 3)), ways), "obj": objects})


# ---- Scenes -------------------------------------------------------------------------------------


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


def towards(m: Maker, scene: Array, count: int) -> Array:
    """Return rays from around the scene towards its spheres."""
    balls = scene[scene["type"] == int(m.core.constants["SPHERE"])]
    target = balls["center"][m.rng.integers(len(balls), size=count)] + m.uniform(-1, 1, count, 3)
    start = m.unit(count) * m.uniform(8, 12, count, 1)
    return m.rays(start, norm1(target - start))


def _search(m: Maker, scene: Array, rays: Array) -> Batch:
    args = {"r": rays, "it": m.blank("intersection", len(rays))}
    batch = Batch("intersect_scene", args, m.world(scene, shading=False))
    return m.steady(batch, "r.orig") if len(scene) else batch


def _scenes() -> list[Recipe]:
    suites = {"nearest": _nearest, "meets": _meets, "kinds": _kinds, "nothing": _nothing}
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
    clouds = [cloud(m, size) for size in (4, 9, 16)]
    return [_search(m, scene, towards(m, scene, count)) for scene in clouds]


def _nearest(m: Maker) -> list[Batch]:
    orders = ([0, 1, 2], [2, 1, 0])
    rows = [_search(m, row_of_spheres(m, order), _along_z(m)) for order in orders]
    return [only(each, result(m.ask(each))) for each in rows + _drawn(m, 60)]


def _meets(m: Maker) -> list[Batch]:
    aside = m.rays([(0, 5, 9), (0, 0, 9)], [(0, 0, -1), (0, 0, 1)])
    single = m.objects("SPHERE", 1, center=(0, 0, 0), radius=1)
    return [_search(m, single, stack(_along_z(m)[:1], aside)), *_drawn(m, 30)]


def _kinds(m: Maker) -> list[Batch]:
    kinds = [cloud(m, 2, planes=1), cloud(m, 6, planes=2)]
    return [_search(m, scene, towards(m, scene, 50)) for scene in kinds]


def _nothing(m: Maker) -> list[Batch]:
    meets = _meets(m)
    # Last, and along rays that would meet what a larger scene has left behind in scene[0].
    left = towards(m, meets[-1].globals["scene"][:1], 9)
    empty = _search(m, m.core.zeros("object", 0), stack(_along_z(m), left))
    return [*[only(each, ~result(m.ask(each))) for each in meets], empty]


# ---- Colours ------------------------------------------------------------------------------------


def lit(m: Maker, scene: Array, **changed: bool) -> dict[str, Array]:
    """Return the globals of a scene with two lights."""
    lights = m.lights([(5, 9, 7), (-8, 6, 2)], [(1, 1, 1), (0.4, 0.5, 0.6)])
    return m.world(scene, lights, **changed)


def _traced() -> list[Recipe]:
    suites = {"object": _colors, "sky": _skies, "depth": _deep}
    made = [Recipe(f"trace_ray.{k}", make, COLOR, COLOR_REASON) for k, make in suites.items()]
    return [*made, Recipe("raytrace", lambda m: [_picture(m)], COLOR, COPIED)]


def _seen(m: Maker) -> list[tuple[Batch, Batch]]:
    """Return calls of trace_ray in several scenes: those that meet an object, and the others."""
    simple = m.rays([(0, 0, 9)], [(0, 0, -1)])
    first = (row_of_spheres(m, [0, 1, 2]), simple)
    scenes = [first, *((s, towards(m, s, 40)) for s in (cloud(m, 5), cloud(m, 9)))]
    made = []
    for scene, rays in scenes:
        search = _search(m, scene, stack(rays, m.rays([(0, 20, 9)], [(0, 0, -1)])))
        hit = result(m.ask(search))
        found, lost = search.args["r"][hit], search.args["r"][~hit]
        found["depth"] = m.rng.integers(0, 8, len(found))
        found["depth"][0] = 0
        batch = Batch("trace_ray", {"r": found}, lit(m, scene))
        made.append((batch, replace(batch, args={"r": lost})))
    return made


def _colors(m: Maker) -> list[Question]:
    return [_to_the_limit(m, found) for found, _ in _seen(m)]


def _skies(m: Maker) -> list[Question]:
    return [m.stages(lost) for _, lost in _seen(m)]


def _deep(m: Maker) -> list[Question]:
    made = []
    for found, _ in _seen(m):
        deep = stack(found.args["r"], found.args["r"])
        deep["depth"][: found.count] = 12 - np.arange(found.count) % 2
        made.append(_to_the_limit(m, replace(found, args={"r": deep})))
    return made


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
