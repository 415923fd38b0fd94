"""From the eye to a colour: camera rays, the nearest hit, hit_color, trace_ray, samples."""

from __future__ import annotations

import numpy as np
import pytest

from grader.execution.session import Library, Session
from grader.tests.core import oracles
from grader.tests.core.oracles import Array, norm, unit
from grader.tests.core.worlds import (
    garbage,
    objects,
    rays,
    same_bytes,
    set_lights,
    set_options,
    set_scene,
)

CASES = 2000
WIDTH, HEIGHT = 96, 64
SKY = np.array([0.2, 0.2, 0.6], np.float32)
ORACLES = {
    "plane": oracles.plane,
    "sphere": oracles.sphere,
    "cylinder": oracles.cylinder,
    "cone": oracles.cone,
}


def test_camera_ray(s: Session, reference: Library, rng: np.random.Generator) -> None:
    """From the camera's position through (x, y) of the image plane, written whole."""
    places = rng.normal(0, 3, (4, 3, 3))
    for position, at, up in places:
        cam = s.call("init_camera", position, at, up, 70, WIDTH / HEIGHT).result
        s.set("theCamera", cam)
        x, y = rng.uniform(0, WIDTH, CASES), rng.uniform(0, HEIGHT, CASES)
        r = s.call_many("camera_ray", CASES, garbage(reference, rng, "ray", CASES), x, y).args["r"]
        z = unit(at - position)
        right = unit(np.cross(up, z))
        tangent = np.tan(np.radians(35))
        across = np.outer((x / WIDTH * 2 - 1) * tangent, right)
        upwards = np.outer((y / HEIGHT * 2 - 1) * tangent * HEIGHT / WIDTH, np.cross(z, right))
        np.testing.assert_allclose(r["dir"], unit(z + across + upwards), rtol=0, atol=2e-6)
        np.testing.assert_allclose(r["orig"], np.broadcast_to(position, (CASES, 3)), rtol=1e-6)
        for name, value in {"tmin": 0, "tmax": 1000, "depth": 0, "seed": 1}.items():
            assert (r[name] == value).all(), name


def mixed(core: Library, rng: np.random.Generator) -> Array:
    """Return forty objects of the four types."""
    world = core.zeros("object", 40)
    for k, kind in enumerate(ORACLES):
        world[k::4] = objects(core, rng, kind, 10)
    world["radius"] *= 0.5
    return world


@pytest.mark.parametrize("function", ["intersect_scene", "nearest_hit"])
def test_the_nearest_hit_is_brute_force(
    s: Session, reference: Library, rng: np.random.Generator, function: str
) -> None:
    """The smallest t of all the objects, its normal and its object's material."""
    world = mixed(reference, rng)
    set_scene(s, world)
    r = rays(reference, rng, rng.uniform(-2, 2, (CASES, 3)))
    t, clear = np.full(CASES, np.inf), np.ones(CASES, bool)
    normal, kd = np.zeros((2, CASES, 3))
    for k, obj in enumerate(world):
        kind = list(ORACLES)[k % 4]
        found = ORACLES[kind](r, np.broadcast_to(obj, CASES))
        want = oracles.nearest(found, r["tmin"], r["tmax"])
        first = want.hit & (want.t < t)
        t[first], normal[first], kd[first] = want.t[first], want.normal[first], obj["mat"]["kd"]
        clear &= want.clear
    it = garbage(reference, rng, "intersection", CASES)
    got = s.call_many(function, CASES, r, it)
    hit = np.isfinite(t)
    np.testing.assert_array_equal(got.result[clear], hit[clear])
    sure = clear & hit
    assert sure.sum() > 500
    np.testing.assert_allclose(got.args["r"]["tmax"][sure], t[sure], rtol=1e-3)
    same = (np.abs(got.args["it"]["mat"]["kd"][sure] - kd[sure]) == 0).all(axis=1)
    # Two surfaces may cross within the rounding.
    assert same.mean() > 0.998
    turned = norm(got.args["it"]["normal"][sure] - normal[sure])[same]
    assert (turned < 1e-2).mean() > 0.998
    assert same_bytes(got.args["it"], it)[~got.result].all()
    assert same_bytes(got.args["r"], r)[~got.result].all()


def test_nearest_hit_paints_the_pattern(s: Session, reference: Library) -> None:
    """A hit's kd is what checker_color says there; an object of no known type is not seen."""
    mat = reference.zeros("material")
    mat["kd"], mat["kd2"], mat["pattern_size"], mat["pattern"] = 1, 0.25, 1, 1
    floor = s.call("init_plane", 0, 1, 0, -0.5, mat).result
    strange = floor.copy()
    strange["type"] = 99
    set_scene(s, np.array([strange, floor]))
    r = reference.zeros("ray", 4)
    r["orig"] = [(0.5, 3, 0.5), (1.5, 3, 0.5), (1.5, 3, 1.5), (-0.5, 3, 0.5)]
    r["dir"], r["tmax"] = (0, -1, 0), 100
    got = s.call_many("nearest_hit", 4, r, reference.zeros("intersection", 4))
    np.testing.assert_array_equal(got.args["it"]["mat"]["kd"][:, 0], [1, 0.25, 1, 0.25])
    assert not s.call("intersect_object", r[0], reference.zeros("intersection"), strange).result


def test_trace_ray_stops(s: Session, reference: Library) -> None:
    """Sky in an empty scene; black beyond max_depth, not at it."""
    set_scene(s, reference.zeros("object", 0))
    r = reference.zeros("ray", 12)
    r["dir"], r["tmax"], r["depth"] = (0, 0, 1), 1000, np.arange(12)
    got = s.call_many("trace_ray", 12, r).result
    np.testing.assert_array_equal(got[:11], np.broadcast_to(SKY, (11, 3)))
    np.testing.assert_array_equal(got[11], 0)
    np.testing.assert_array_equal(s.call("sky_color").result, SKY)
    set_options(s, max_depth=0)
    got = s.call_many("trace_ray", 12, r).result
    np.testing.assert_array_equal(got[1:], 0)


def test_bounces_between_two_mirrors_are_counted(s: Session, reference: Library) -> None:
    """Between two facing mirrors that send 1/2 back and glow by 1: 1 + 1/2 + 1/4 + ..."""
    mat = reference.zeros("material")
    mat["ks"] = 0.5
    mat["kd"] = np.pi
    walls = [s.call("init_plane", 0, side, 0, 1, mat).result for side in (1, -1)]
    set_scene(s, np.array(walls))
    # A light at the middle shines straight on both points that the ray meets; no highlight.
    mat["shininess"] = 0
    set_options(s, fresnel=False, shadows=False)
    set_lights(s, reference, np.zeros((1, 3)), np.ones((1, 3)))
    r = reference.zeros("ray")
    r["dir"], r["tmax"] = (0, 1, 0), 1000
    one = 1 + 0.5 * 8 / (8 * np.pi)
    for depth in range(6):
        set_options(s, max_depth=depth)
        got = s.call("trace_ray", r).result
        np.testing.assert_allclose(got, one * (2 - 0.5**depth), rtol=1e-5)


def test_hit_color_switches(s: Session, reference: Library) -> None:
    """No shading: kd; opaque: direct + mirror; transparent: direct + glass, unless it is off."""
    set_scene(s, reference.zeros("object", 0))
    set_lights(s, reference, np.array([(0, 9, 0)]), np.ones((1, 3)))
    it, r = reference.zeros("intersection"), reference.zeros("ray")
    it["normal"], r["dir"] = (0, 1, 0), (0, -1, 0)
    mat = it["mat"]
    mat["kd"], mat["ks"], mat["kr"], mat["shininess"] = 0.25, 0.5, 0.125, 10
    v = (0, 1, 0)
    direct = s.call("direct_light", it, v).result
    mirror = s.call("mirror_color", r, it).result

    def color(**switches: bool) -> Array:
        set_options(s, **{"shading": True, "reflections": True, "refraction": True} | switches)
        return np.asarray(s.call("hit_color", r, it).result)

    assert (direct > 0).all()
    np.testing.assert_array_equal(color(shading=False), 0.25)
    np.testing.assert_array_equal(color(reflections=False), direct)
    np.testing.assert_array_equal(color(), direct + mirror)
    mat["refraction_index"] = 1.5
    np.testing.assert_array_equal(color(shading=False), 0.25)
    np.testing.assert_array_equal(color(refraction=False), direct + mirror)
    # The scene is empty: sky by either way.
    np.testing.assert_array_equal(color(), direct + SKY)


def test_pixel_color_is_the_mean_of_clamped_samples(
    s: Session, reference: Library, rng: np.random.Generator
) -> None:
    """The mean of samples x samples squares' middles, each clamped to [0, 1], with its own seed."""
    s.call("setup_scene", 0)
    set_options(s, samples=3)
    i, j = rng.integers(0, WIDTH, 1500), rng.integers(0, HEIGHT, 1500)
    total, raw = np.zeros((2, i.size, 3))
    for k in range(9):
        x, y = i + (k % 3 + 0.5) / 3, j + (k // 3 + 0.5) / 3
        r = s.call_many("camera_ray", i.size, reference.zeros("ray"), x, y).args["r"]
        colors = s.call_many("trace_ray", i.size, r).result
        raw += colors / 9
        total += np.clip(colors, 0, 1) / 9
    got = s.call_many("pixel_color", i.size, i, j).result
    np.testing.assert_allclose(got, total, rtol=0, atol=2e-6)
    assert np.abs(raw - total).max() > 0.1
