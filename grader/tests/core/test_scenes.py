"""The scenes of the handout as its tables give them, what builds a scene, and a full one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from grader.execution.session import Library, Session
from grader.tests.core.oracles import Array, dot, norm, unit
from grader.tests.core.worlds import materials

# A material is (kd, ks, shininess, kr); a grey is written as one number.
GREY = ((0.5, 0.5, 0.5), (0.5, 0.5, 0.5), 200, 0.5)
FLOOR_0 = ((0, 1, 0), 0.2, ((0.5, 0.9, 0.7), 0.01, 50, 0.01))
SPHERES_0 = [
    ((0, 0, 0), 0.3, GREY),
    ((1, -0.05, 0), 0.15, ((0.9, 0, 0), 0.1, 500, 0.1)),
    ((0, 1, 0), 0.25, ((0, 1, 0), 0, 0.01, 0)),
    ((0, -0.05, 1), 0.2, ((0, 0, 0.6), 0.4, 20, 0.4)),
]
SPHERES_1 = [
    ((0, -0.05, 1), 0.2, ((0, 0, 1), 0.5, 20, 0.5)),
    ((0, 1, 0), 0.15, ((0, 1, 0), 0.1, 20, 0.04)),
    ((1, -0.05, 0), 0.15, ((1, 0, 0), 0.1, 500, 0.04)),
]
FLOOR_1 = ((0, 1, 0), 0.2, ((0.5, 1, 0.7), 0.1, 500, 0.04))
LIGHTS_1 = [((-2, 1.7, 3), 1), ((3, 2, 3), 0.4), ((4, 3, -10), 0.5)]
LIGHTS_4 = [((0, 1.7, 1), 1), ((3, 2, 3), 0.4), ((4, 3, -1), 0.5)]
PLANES_4 = [
    FLOOR_0,
    ((1, 0, -1), 2, ((0.8, 0.09, 0.07), (0.2, 0.2, 0.1), 10, (0.2, 0.2, 0.1))),
    ((0.3, -0.2, 1), 3, ((0.1, 0.3, 0.05), 0.5, 100, 0.5)),
]
FIRST = {1: ((0, 0, 0), 0.3, (0.5, 0.5, 20, 0.8)), 2: ((0, 0, 0), 0.3, (1, 0.5, 20, 0.8))}
# Lights, spheres and planes of the scenes that are tables.
TABLES: dict[int, tuple[Any, Any, Any]] = {
    0: ([((-200, 170, 300), 2)], SPHERES_0, [FLOOR_0]),
    1: (LIGHTS_1, [FIRST[1], *SPHERES_1], [FLOOR_1]),
    2: (LIGHTS_1, [FIRST[2], *SPHERES_1], [FLOOR_1]),
    4: (LIGHTS_4, SPHERES_0, PLANES_4),
}


def scene(s: Session, number: int) -> Array:
    """Set a scene up; return its objects."""
    assert s.call("setup_scene", number).result
    return s.get("scene", int(s.get("object_count")))


def check_matter(mat: Array, matter: Sequence[Any]) -> None:
    """Hold a material's optics, and that it is opaque and plain."""
    for name, value in zip(("kd", "ks", "shininess", "kr"), matter, strict=True):
        want = np.broadcast_to(np.asarray(value, np.float32), mat[name].shape)
        np.testing.assert_array_equal(mat[name], want, err_msg=name)
    assert mat["refraction_index"] == mat["pattern"] == 0


@pytest.mark.parametrize("number", TABLES)
def test_scenes_are_the_handouts(s: Session, reference: Library, number: int) -> None:
    """Lights, spheres and planes, in any order among the types."""
    world = scene(s, number)
    lamps, balls, planes = TABLES[number]
    found = s.get("lights", int(s.get("num_lights")))
    for lamp, (position, level) in zip(found, lamps, strict=True):
        np.testing.assert_array_equal(lamp["position"], np.float32(position))
        np.testing.assert_array_equal(lamp["col"], np.float32(level))
    spheres = world[world["type"] == reference.constants["SPHERE"]]
    for obj, (center, radius, matter) in zip(spheres, balls, strict=True):
        np.testing.assert_array_equal(obj["center"], np.float32(center))
        assert obj["radius"] == np.float32(radius)
        check_matter(obj["mat"], matter)
    floors = world[world["type"] == reference.constants["PLANE"]]
    for obj, (normal, dist, matter) in zip(floors, planes, strict=True):
        np.testing.assert_allclose(obj["normal"], unit(np.array(normal, float)), atol=1e-7)
        assert obj["dist"] == np.float32(dist)
        check_matter(obj["mat"], matter)
    tubes = world[world["type"] == reference.constants["CYLINDER"]]
    assert len(world) == len(spheres) + len(floors) + len(tubes)
    assert len(tubes) == (3 if number == 2 else 0)


def test_cylinders_of_scene_2(s: Session, reference: Library) -> None:
    """One along each axis, from the origin, yellow, without reflectance."""
    world = scene(s, 2)
    tubes = world[world["type"] == reference.constants["CYLINDER"]]
    np.testing.assert_array_equal(tubes["axis"], np.eye(3))
    np.testing.assert_array_equal(tubes["base"], 0)
    np.testing.assert_array_equal(tubes["length"], 1)
    np.testing.assert_array_equal(tubes["radius"], np.float32(0.05))
    for mat in tubes["mat"]:
        check_matter(mat, ((1, 1, 0), 0.1, 500, 0))


def test_spheres_of_scene_3(s: Session) -> None:
    """1024 of radius 0.1 all over [0, 2)^3, no two centres within 1e-3, colours all over."""
    world = scene(s, 3)
    assert len(world) == 1024
    assert (world["radius"] == np.float32(0.1)).all()
    center = world["center"].astype(float)
    assert center.min() >= 0
    assert center.max() < 2
    for values, width in ((center, 2), (world["mat"]["kd"].astype(float), 1)):
        deviation = width / np.sqrt(12)
        np.testing.assert_allclose(values.mean(axis=0), width / 2, atol=5 * deviation / 32)
        np.testing.assert_allclose(values.std(axis=0), deviation, rtol=0.1)
    apart = norm(center[:, None] - center[None])
    assert apart[np.triu_indices(1024, 1)].min() >= 1e-3
    assert (world["mat"]["ks"] == 0.5).all()
    assert (world["mat"]["kr"] == np.float32(0.8)).all()
    assert (world["mat"]["shininess"] == 20).all()


@pytest.mark.parametrize("number", range(5))
def test_camera_of_the_handout(s: Session, number: int) -> None:
    """From (2, 1, 3) at (0, 0.3, 0), 60 degrees; a second set-up gives the same objects."""
    world = scene(s, number)
    cam = s.get("theCamera")
    want = s.call("init_camera", (2, 1, 3), (0, 0.3, 0), (0, 1, 0), 60, 96 / 64).result
    for name in want.dtype.names:
        np.testing.assert_allclose(cam[name], want[name], rtol=1e-6, err_msg=name)
    assert cam["aspect"] == 1.5
    assert scene(s, number).tobytes() == world.tobytes()


def test_unknown_scenes_are_refused(s: Session) -> None:
    """Numbers below 0 and beyond the last give false and leave the scene; options as documented."""
    before = scene(s, 0)
    for number in (-1, 11, 2**31 - 1, -(2**31)):
        assert not s.call("setup_scene", number).result
    assert s.get("scene", int(s.get("object_count"))).tobytes() == before.tobytes()
    options = s.get("options")
    for name in ("shading", "shadows", "reflections", "fresnel", "refraction", "octree"):
        assert options[name]
    assert options["samples"] == 1
    assert options["max_depth"] == 10
    assert options["epsilon"] == np.float32(1e-4)


def test_a_full_scene_refuses(s: Session, reference: Library) -> None:
    """SCENE_SIZE objects and MAX_LIGHTS lights fit; the next changes nothing and is noted."""
    size, most = (int(reference.constants[name]) for name in ("SCENE_SIZE", "MAX_LIGHTS"))
    scene(s, 0)
    ball = s.call("init_sphere", 0, 0, 0, 1, reference.zeros("material")).result
    s.set("object_count", size - 1)
    assert s.call("add_object", ball).result
    assert not s.call("scene_is_full").result
    assert not s.call("add_object", ball).result
    assert s.call("scene_is_full").result
    assert s.get("object_count") == size
    scene(s, 1)
    assert not s.call("scene_is_full").result
    assert s.get("num_lights") == most
    assert not s.call("add_light", (0, 0, 0), (1, 1, 1)).result
    assert s.call("scene_is_full").result
    assert s.get("num_lights") == most


@pytest.mark.parametrize("depth", [0, 1, 3])
def test_populate_spheres(s: Session, rng: np.random.Generator, depth: int) -> None:
    """Each sphere carries three of a quarter of its radius, tangent, in the half-space above it."""
    s.set("object_count", 0)
    up = unit(rng.normal(size=3))
    s.call("populate_spheres", (1, 2, 3), 0.5, up, depth)
    count = (3 ** (depth + 1) - 1) // 2
    assert s.get("object_count") == count
    world = s.get("scene", count)
    center, radius = world["center"].astype(float), world["radius"].astype(float)
    np.testing.assert_allclose(center[0], (1, 2, 3))
    above = {0: up}
    for k in range(1, count):
        parents = [p for p in above if np.isclose(radius[p], 4 * radius[k])]
        gaps = [abs(norm(center[k] - center[p]) - 1.25 * radius[p]) for p in parents]
        parent = parents[int(np.argmin(gaps))]
        assert min(gaps) < 1e-6
        above[k] = unit(center[k] - center[parent])
        assert dot(above[k], above[parent]) > 0
    for level in range(depth + 1):
        assert np.isclose(radius, 0.5 / 4**level).sum() == 3**level


def test_populate_spheres_stops_when_the_scene_is_full(s: Session, reference: Library) -> None:
    """Room for five: five, and no endless recursion."""
    size = int(reference.constants["SCENE_SIZE"])
    s.set("object_count", size - 5)
    s.call("populate_spheres", (0, 0, 0), 1, (0, 1, 0), 1000)
    assert s.get("object_count") == size


def test_add_flake(s: Session, reference: Library, rng: np.random.Generator) -> None:
    """Nine tangent spheres of a third on each, evenly about its axis."""
    s.set("object_count", 0)
    mat = materials(reference, rng, 1)[0]
    up = unit(rng.normal(size=3))
    s.call("add_flake", (0, 0, 0), 0.5, up, 2, mat)
    assert s.get("object_count") == 1 + 9 + 81
    world = s.get("scene", 91)
    center, radius = world["center"].astype(float), world["radius"].astype(float)
    children = center[np.isclose(radius, 0.5 / 3)]
    assert len(children) == 9
    np.testing.assert_allclose(norm(children), 0.5 + 0.5 / 3, rtol=1e-6)
    np.testing.assert_allclose(np.cross(children.sum(axis=0), up), 0, atol=1e-5)
    apart = norm(children[:, None] - children[None]) + np.eye(9)
    assert apart.min() > 2 * 0.5 / 3 - 1e-6
    for small in center[np.isclose(radius, 0.5 / 9)]:
        assert np.abs(norm(children - small) - (0.5 / 3 + 0.5 / 9)).min() < 1e-6


def test_scene_changed_follows_the_option(s: Session) -> None:
    """With options.octree there is a tree of the objects; without, none."""
    scene(s, 0)
    assert s.get("scene_octree") != 0
    options = s.get("options").copy()
    options["octree"] = False
    s.set("options", options)
    s.call("scene_changed")
    assert s.get("scene_octree") == 0
