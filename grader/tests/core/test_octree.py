"""The octree finds the hits of the plain list, bit for bit, whatever the scene and the rays."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest

from grader.execution.session import Address, Library, Limits, Session
from grader.tests.core.oracles import Array, dot, norm, unit
from grader.tests.core.worlds import (
    directions,
    garbage,
    objects,
    rays,
    same_bytes,
    set_options,
    set_scene,
)

CASES = 1500
SOLIDS = ("sphere", "cylinder", "cone")
World = Callable[[Library, np.random.Generator], Array]


def mixed(core: Library, rng: np.random.Generator, count: int, size: float = 1) -> Array:
    """Return `count` objects, planes among them from ten on, in any order."""
    obj = core.zeros("object", count)
    for k, kind in enumerate(SOLIDS):
        obj[k::3] = objects(core, rng, kind, len(obj[k::3]))
    obj["radius"] *= size
    if count >= 10:
        obj[:2] = objects(core, rng, "plane", 2)
    return np.asarray(rng.permutation(obj))


def balls(core: Library, centers: Array, radius: float) -> Array:
    """Return equal spheres at these places, of different colours."""
    obj = core.zeros("object", len(centers))
    obj["type"], obj["radius"], obj["center"] = core.constants["SPHERE"], radius, centers
    obj["mat"]["kd"] = np.linspace(0, 1, len(centers))[:, None]
    return obj


def grid(side: int) -> Array:
    """Return the corners of a grid of integers around the origin."""
    steps = np.arange(side) - side // 2
    return np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3)


def columns(core: Library, rng: np.random.Generator) -> Array:
    """Return upright cylinders on integer places, whose discs lie in common planes."""
    obj = objects(core, rng, "cylinder", 60)
    obj["base"], obj["axis"], obj["length"] = rng.integers(-2, 3, (60, 3)), (0, 1, 0), 1
    return obj


WORLDS: dict[str, World] = {
    "nothing": lambda core, rng: core.zeros("object", 0),
    "one object": lambda core, rng: mixed(core, rng, 1),
    "two": lambda core, rng: mixed(core, rng, 2),
    "a few": lambda core, rng: mixed(core, rng, 12),
    "many small": lambda core, rng: mixed(core, rng, 300, 0.1),
    "many that overlap": lambda core, rng: mixed(core, rng, 300),
    "only planes": lambda core, rng: objects(core, rng, "plane", 20),
    "all in one point": lambda core, rng: balls(core, np.zeros((40, 3)), 1),
    "almost in one point": lambda core, rng: balls(core, rng.normal(0, 1e-6, (40, 3)), 0.5),
    "touching": lambda core, rng: balls(core, grid(5), 0.5),
    "in one plane": lambda core, rng: balls(core, rng.normal(size=(90, 3)) * (1, 0, 1), 0.1),
    "on one line": lambda core, rng: balls(core, rng.normal(size=(90, 3)) * (0, 0, 2), 0.1),
    "two far clusters": lambda core, rng: balls(
        core, rng.normal(0, 0.3, (80, 3)) + rng.choice([-40, 40], (80, 1)), 0.1
    ),
    "coplanar discs": columns,
}


def hits_both_ways(s: Session, core: Library, r: Array) -> tuple[Array, Array]:
    """Return, for each ray, whether tree and list agree to the last bit, and whether they hit."""
    it = core.zeros("intersection", len(r))
    replies = []
    for octree in (True, False):
        set_options(s, octree=octree)
        replies.append(s.call_many("nearest_hit", len(r), r, it))
    tree, plain = replies
    equal = same_bytes(tree.args["r"], plain.args["r"])
    equal &= same_bytes(tree.args["it"], plain.args["it"])
    return equal & (tree.result == plain.result), plain.result


@pytest.mark.parametrize("name", WORLDS)
def test_random_rays_hit_the_same(
    s: Session, reference: Library, rng: np.random.Generator, name: str
) -> None:
    """Rays from inside and outside, whole or cut to [tmin, tmax]; a miss changes nothing."""
    world = WORLDS[name](reference, rng)
    set_scene(s, world)
    aim = rng.uniform(-2, 2, (CASES, 3))
    if name == "two far clusters":
        aim = world["center"][rng.integers(len(world), size=CASES)]
    r = rays(reference, rng, aim)
    equal, hit = hits_both_ways(s, reference, r)
    assert equal.all()
    assert hit.any() == (len(world) > 0)


@pytest.mark.parametrize("distance", [30, 300])
def test_from_far_away(
    s: Session, reference: Library, rng: np.random.Generator, distance: float
) -> None:
    """An eye at many times the scene's size sees the same by both ways."""
    set_scene(s, mixed(reference, rng, 300, 0.1))
    r = rays(reference, rng, rng.uniform(-2, 2, (CASES, 3)))
    r["orig"] -= distance * unit(r["dir"])
    r["tmin"], r["tmax"] = 0, 1e30
    equal, hit = hits_both_ways(s, reference, r)
    assert equal.all()
    assert hit.mean() > 0.5


@pytest.mark.parametrize("name", ["touching", "many small", "coplanar discs"])
def test_rays_along_axes_and_in_cutting_planes(
    s: Session, reference: Library, rng: np.random.Generator, name: str
) -> None:
    """Directions with zeros, +0 and -0, from points that lie in the planes between the boxes."""
    world = WORLDS[name](reference, rng)
    set_scene(s, world)
    r = rays(reference, rng, rng.uniform(-2, 2, (CASES, 3)))
    r["tmin"], r["tmax"] = 0, 1e5
    r["dir"] = rng.choice([-1.0, -0.0, 0.0, 1.0], (CASES, 3), p=[0.2, 0.3, 0.3, 0.2])
    root = s.get("scene_octree")
    low, high = (s.peek(int(root), "octree_node")["bounds"][side] for side in ("min", "max"))
    cuts = low + (high - low) * (rng.integers(-4, 13, (CASES, 3)) / np.float32(8))
    r["orig"] = np.where(rng.random((CASES, 3)) < 0.7, cuts, r["orig"])
    equal, hit = hits_both_ways(s, reference, r)
    assert equal.all()
    assert hit.mean() > 0.1


def nodes(s: Session, address: int) -> Iterator[Array]:
    """Walk the tree: every node, parents before their children."""
    node = s.peek(address, "octree_node")
    yield node
    for child in node["child"]:
        if child:
            yield from nodes(s, int(child))


def listed(s: Session, node: Array) -> Array:
    """Return the indices that a node lists."""
    if not node["object_count"]:
        return np.zeros(0, np.int32)
    return s.peek(int(node["objects"]), "int", int(node["object_count"]))


def surface_points(rng: np.random.Generator, obj: Array, count: int) -> Array:
    """Return points on the sides of spheres, cylinders and cones, shape (count, n, 3)."""
    out = directions(rng, count * len(obj)).reshape(count, len(obj), 3)
    axis = obj["axis"].astype(float)
    height = rng.random((count, len(obj)))
    rim = unit(out - dot(out, axis)[..., None] * axis)
    shrink = np.where(obj["type"] == 4, 1 - height, 1) * obj["radius"]
    side = obj["base"] + (height * obj["length"])[..., None] * axis + shrink[..., None] * rim
    ball = obj["center"] + obj["radius"][:, None] * out
    return np.asarray(np.where((obj["type"] == 1)[:, None], ball, side))


@pytest.mark.parametrize("name", ["a few", "many small", "many that overlap", "touching"])
def test_the_tree_covers_every_object(scenes: Library, rng: np.random.Generator, name: str) -> None:
    """A leaf lists every object with a point in its box; no point lies out of all; no planes."""
    world = WORLDS[name](scenes, rng)
    with scenes.session() as s:
        root = s.call("octree_build", s.buffer(world), len(world)).result
        tree = [(node, listed(s, node)) for node in nodes(s, root)]
    solid = world["type"] != scenes.constants["PLANE"]
    points = surface_points(rng, world, 40)
    found = np.zeros(points.shape[:2], bool)
    for node, indices in tree:
        if node["child"].any():
            assert not len(indices)
            continue
        box = node["bounds"]
        within = ((points >= box["min"]) & (points <= box["max"])).all(axis=2)
        lacking = within.any(axis=0) & solid
        lacking[indices] = False
        assert not lacking.any()
        assert solid[indices].all()
        found |= within
    assert found[:, solid].all()


def test_no_tree_for_nothing(s: Session, reference: Library, rng: np.random.Generator) -> None:
    """No objects or only planes: NULL, which octree_free accepts."""
    assert s.call("octree_build", None, 0).result == 0
    flat = s.buffer(objects(reference, rng, "plane", 5))
    assert s.call("octree_build", flat, 5).result == 0
    s.call("octree_free", None)


@pytest.mark.parametrize("name", ["all in one point", "many that overlap"])
def test_overlapping_objects_do_not_fill_the_memory(
    scenes: Library, rng: np.random.Generator, name: str
) -> None:
    """A thousand objects that cutting cannot part: a tree of a few entries for each."""
    count = 1000
    piled = balls(scenes, np.zeros((count, 3)), 1)
    world = piled if name == "all in one point" else mixed(scenes, rng, count)
    with scenes.session(Limits(memory=64 << 20)) as s:
        root = s.call("octree_build", s.buffer(world), count).result
        assert isinstance(root, Address)
        entries = sum(int(node["object_count"]) for node in nodes(s, root))
    assert count - 2 <= entries < 60 * count


@pytest.mark.parametrize("kind", SOLIDS)
def test_box_overlaps_object(
    s: Session, reference: Library, rng: np.random.Generator, kind: str
) -> None:
    """True when a point of the object is in the box; false for boxes away, and for planes."""
    obj = objects(reference, rng, kind, CASES)
    box = reference.zeros("box", CASES)
    center, half = rng.uniform(-4, 4, (CASES, 3)), rng.uniform(0, 2, (CASES, 3))
    box["min"], box["max"] = center - half, center + half
    points = surface_points(rng, obj, 60)
    touches = ((points >= box["min"]) & (points <= box["max"])).all(axis=2).any(axis=0)
    got = s.call_many("box_overlaps_object", CASES, box, obj).result
    assert touches.sum() > 50
    assert got[touches].all()
    middle = obj["center"] if kind == "sphere" else obj["base"]
    reach = obj["radius"] + (0 if kind == "sphere" else obj["length"])
    nearest_point = np.clip(middle, box["min"], box["max"])
    if kind == "sphere":
        exact = norm(nearest_point - middle.astype(float)) - reach
        sure = np.abs(exact) > 1e-5
        np.testing.assert_array_equal(got[sure], exact[sure] < 0)
    away = (np.abs(nearest_point - middle) > reach[:, None]).any(axis=1)
    assert away.sum() > 100
    assert not got[away].any()
    flat = objects(reference, rng, "plane", CASES)
    assert not s.call_many("box_overlaps_object", CASES, box, flat).result.any()


def test_octree_intersect_leaves_planes_out(
    s: Session, reference: Library, rng: np.random.Generator
) -> None:
    """The tree alone sees what the list without planes sees; a miss changes nothing."""
    world = mixed(reference, rng, 60, 0.2)
    set_scene(s, world)
    tree = Address(int(s.get("scene_octree")))
    r = rays(reference, rng, rng.uniform(-2, 2, (CASES, 3)))
    it = garbage(reference, rng, "intersection", CASES)
    got = s.call_many("octree_intersect", CASES, tree, r, it)
    set_scene(s, world[world["type"] != reference.constants["PLANE"]])
    want = s.call_many("intersect_scene", CASES, r, it)
    np.testing.assert_array_equal(got.result, want.result)
    assert 0.1 < got.result.mean() < 0.9
    assert same_bytes(got.args["r"], want.args["r"]).all()
    assert same_bytes(got.args["it"], want.args["it"]).all()
    assert same_bytes(got.args["it"], it)[~got.result].all()
