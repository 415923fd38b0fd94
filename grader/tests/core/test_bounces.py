"""Shadow, mirror and glass: the rays that go on from a point hit."""

from __future__ import annotations

import numpy as np
import pytest

from grader.execution.session import Library, Session
from grader.tests.core import oracles
from grader.tests.core.oracles import Array, dot, norm, unit
from grader.tests.core.worlds import (
    directions,
    garbage,
    materials,
    objects,
    same_bytes,
    set_options,
    set_scene,
)

CASES = 3000
SKY = np.array([0.2, 0.2, 0.6], np.float32)
EPSILON = 1e-4


def arrivals(core: Library, rng: np.random.Generator, count: int = CASES) -> tuple[Array, Array]:
    """Return rays, |dir| from 0.01 to 100, and the points that they hit from either side."""
    r, it = core.zeros("ray", count), core.zeros("intersection", count)
    it["normal"], it["position"] = directions(rng, count), rng.uniform(-2, 2, (count, 3))
    it["mat"] = materials(core, rng, count)
    r["orig"] = it["position"] + directions(rng, count)
    r["dir"] = (it["position"] - r["orig"]) * 10 ** rng.uniform(-2, 2, (count, 1))
    r["tmin"], r["tmax"] = 0.5, 77
    r["depth"] = rng.integers(0, 10, count)
    r["seed"] = rng.integers(1, 2**32, count)
    return r, it


def check_bounced(out: Array, r: Array, it: Array, way: Array) -> None:
    """Hold what every bounced ray has, when it should go in the direction `way`."""
    np.testing.assert_allclose(out["dir"], way, rtol=0, atol=3e-5)
    np.testing.assert_allclose(norm(out["dir"].astype(float)), 1, rtol=0, atol=3e-7)
    start = it["position"].astype(float) + EPSILON * way
    np.testing.assert_allclose(out["orig"], start, rtol=0, atol=3e-7)
    np.testing.assert_array_equal(out["depth"], r["depth"] + 1)
    np.testing.assert_array_equal(out["seed"], r["seed"])
    assert (out["tmin"] == 0).all()
    assert (out["tmax"] == 1000).all()


def test_reflected_ray(s: Session, reference: Library, rng: np.random.Generator) -> None:
    """Angles equal, one plane, unit, moved by epsilon, one deeper, with its parent's seed."""
    r, it = arrivals(reference, rng)
    out = garbage(reference, rng, "ray", CASES)
    got = s.call_many("reflected_ray", CASES, out, r, it).args
    d, n = unit(r["dir"].astype(float)), it["normal"].astype(float)
    check_bounced(got["out"], r, it, oracles.reflected(d, n))
    bounced = got["out"]["dir"].astype(float)
    np.testing.assert_allclose(dot(bounced, n), -dot(d, n), rtol=0, atol=1e-6)
    np.testing.assert_allclose(dot(np.cross(d, n), bounced), 0, rtol=0, atol=1e-6)
    assert same_bytes(got["in"], r).all()
    assert same_bytes(got["it"], it).all()


def test_epsilon_is_an_option(s: Session, reference: Library, rng: np.random.Generator) -> None:
    """options.epsilon is by how much a bounced ray is moved."""
    r, it = arrivals(reference, rng, 100)
    it["mat"]["refraction_index"] = 1
    set_options(s, epsilon=0.25)
    for name in ("reflected_ray", "refracted_ray"):
        out = s.call_many(name, 100, reference.zeros("ray", 100), r, it).args["out"]
        np.testing.assert_allclose(out["orig"], it["position"] + 0.25 * out["dir"], atol=1e-6)


def test_refracted_ray(s: Session, reference: Library, rng: np.random.Generator) -> None:
    """Snell's law from both sides, one plane; total reflection writes nothing."""
    r, it = arrivals(reference, rng)
    it["mat"]["refraction_index"] = rng.uniform(0.6, 2.5, CASES)
    d, n = r["dir"].astype(float), it["normal"].astype(float)
    way, sine = oracles.refracted(d, n, it["mat"]["refraction_index"].astype(float))
    out = garbage(reference, rng, "ray", CASES)
    got = s.call_many("refracted_ray", CASES, out, r, it)
    sure = np.abs(sine - 1) > 1e-3
    np.testing.assert_array_equal(got.result[sure], sine[sure] < 1)
    total = ~got.result
    assert 0.1 < total.mean() < 0.5
    assert same_bytes(got.args["out"], out)[total].all()
    through = sure & got.result
    # Near the critical angle the direction turns as the root of the rounding.
    check_bounced(got.args["out"][through], r[through], it[through], way[through])
    bounced = got.args["out"]["dir"][through].astype(float)
    assert (np.sign(dot(bounced, n[through])) == np.sign(dot(d, n)[through])).all()
    assert same_bytes(got.args["in"], r).all()


def test_refraction_at_its_edges(s: Session, reference: Library) -> None:
    """Straight on at normal incidence and at index 1; grazing; 42 degrees inside glass."""
    it, r = reference.zeros("intersection"), reference.zeros("ray")
    it["normal"] = (0, 1, 0)

    def go(index: float, *way: float) -> Array:
        """Return the new direction, or none: an empty array."""
        it["mat"]["refraction_index"], r["dir"] = index, way
        reply = s.call("refracted_ray", reference.zeros("ray"), r, it)
        return np.asarray(reply.args["out"]["dir"] if reply.result else [])

    np.testing.assert_allclose(go(1.5, 0, -3, 0), (0, -1, 0))
    np.testing.assert_allclose(go(1.5, 0, 3, 0), (0, 1, 0))
    np.testing.assert_allclose(go(1, 0.6, -0.8, 0), (0.6, -0.8, 0), atol=1e-6)
    np.testing.assert_allclose(go(1, 0.6, 0.8, 0), (0.6, 0.8, 0), atol=1e-6)
    np.testing.assert_allclose(go(2, 1, 0, 0), (0.5, -(0.75**0.5), 0), atol=1e-6)
    critical = np.arcsin(1 / 1.5)
    below, above = critical - 0.01, critical + 0.01
    assert go(1.5, np.sin(below), np.cos(below), 0).size == 3
    assert go(1.5, np.sin(above), np.cos(above), 0).size == 0
    assert np.isfinite(go(1.5, 0, 0, 0)).all()


@pytest.mark.parametrize("octree", [False, True])
def test_in_shadow_is_brute_force(
    s: Session, reference: Library, rng: np.random.Generator, octree: bool
) -> None:
    """Barred when one of 30 spheres stands between epsilon and the light, and only then."""
    balls = objects(reference, rng, "sphere", 30)
    balls["radius"] *= 0.4
    set_scene(s, balls)
    set_options(s, octree=octree)
    it, lamp = reference.zeros("intersection", CASES), reference.zeros("light", CASES)
    it["position"], lamp["position"] = rng.uniform(-3, 3, (2, CASES, 3))
    r = reference.zeros("ray", CASES)
    r["orig"] = it["position"]
    way = lamp["position"].astype(float) - it["position"]
    r["dir"] = unit(way)
    barred, clear = np.zeros(CASES, bool), np.ones(CASES, bool)
    for ball in balls:
        found = oracles.sphere(r, np.broadcast_to(ball, CASES))
        want = oracles.nearest(found, np.full(CASES, EPSILON), norm(way))
        barred |= want.hit & want.clear
        clear &= want.clear
    got = s.call_many("in_shadow", CASES, it, lamp).result
    np.testing.assert_array_equal(got[clear | barred], barred[clear | barred])
    assert 0.2 < barred.mean() < 0.8
    assert (clear | barred).mean() > 0.9


def test_shadow_at_its_edges(s: Session, reference: Library, rng: np.random.Generator) -> None:
    """No acne on the surface itself, its far side is dark, nothing beyond the light counts."""
    ball = s.call("init_sphere", 0, 0, 0, 1, reference.zeros("material")).result
    set_scene(s, np.array([ball]))
    it, lamp = reference.zeros("intersection", CASES), reference.zeros("light", CASES)
    outwards = directions(rng, CASES)
    it["position"] = outwards
    for distance in (0.01, 3, 1e4):
        lamp["position"] = outwards * (1 + distance)
        assert not s.call_many("in_shadow", CASES, it, lamp).result.any()
        lamp["position"] = -outwards * (1 + distance)
        assert s.call_many("in_shadow", CASES, it, lamp).result.all()
    it["position"], lamp["position"] = outwards * 3, outwards * 1.25
    assert not s.call_many("in_shadow", CASES, it, lamp).result.any()
    lamp["position"] = it["position"]
    assert not s.call_many("in_shadow", CASES, it, lamp).result.any()
    it["position"] = lamp["position"] = outwards * 0.5
    assert not s.call_many("in_shadow", CASES, it, lamp).result.any()


def test_mirror_color(s: Session, reference: Library, rng: np.random.Generator) -> None:
    """The sky times k = ks, or Schlick of n.v with Fresnel; black beyond the depth limit."""
    set_scene(s, reference.zeros("object", 0))
    r, it = arrivals(reference, rng)
    r["depth"] = rng.integers(8, 12, CASES)
    cosine = -dot(unit(r["dir"].astype(float)), it["normal"].astype(float))
    lit = (r["depth"] + 1 <= 10)[:, None]
    assert 0.4 < lit.mean() < 0.6
    for fresnel in (False, True):
        set_options(s, fresnel=fresnel)
        k = oracles.schlick(it["mat"]["kr"], cosine) if fresnel else it["mat"]["ks"]
        got = s.call_many("mirror_color", CASES, r, it).result
        np.testing.assert_allclose(got, np.where(lit, k * SKY, 0), rtol=0, atol=2e-6)


def glass_over_a_red_floor(s: Session, core: Library, *, inside: bool) -> tuple[Array, Array]:
    """Return an arrival on a level face of glass: reflected rays see one colour, others another.

    The sky is above, a plane of colour (1, 0, 0) below.
    """
    floor = core.zeros("material")
    floor["kd"] = (1, 0, 0)
    set_scene(s, np.array([s.call("init_plane", 0, 1, 0, 5, floor).result]))
    set_options(s, shading=False)
    r, it = core.zeros("ray"), core.zeros("intersection")
    it["normal"] = (0, -1, 0) if inside else (0, 1, 0)
    it["mat"]["refraction_index"], it["mat"]["ks"] = 1.5, (0.1, 0.3, 0.5)
    return r, it


@pytest.mark.parametrize("inside", [False, True])
@pytest.mark.parametrize("degrees", [0, 35, 80])
@pytest.mark.parametrize("fresnel", [True, False])
def test_glass_color_draws_by_fresnel(
    s: Session, reference: Library, inside: bool, degrees: float, fresnel: bool
) -> None:
    """One ray or the other, reflected as often as Fresnel, or the mean of ks, says."""
    count = 2500
    r, it = glass_over_a_red_floor(s, reference, inside=inside)
    set_options(s, fresnel=fresnel)
    angle = np.radians(degrees)
    r["dir"] = (np.sin(angle), -np.cos(angle), 0)
    many = np.repeat(r[None], count)
    many["seed"] = np.arange(count)
    reply = s.call_many("glass_color", count, many, it)
    mirrored = (reply.result == SKY).all(axis=1)
    # Reflected and transmitted make all: there is no third colour.
    np.testing.assert_array_equal(reply.result[~mirrored] - (1, 0, 0), 0)
    share = float(oracles.schlick(np.full(3, 0.04), np.cos(angle))[0]) if fresnel else 0.3
    if inside and degrees > 42:
        assert mirrored.all()
    else:
        assert mirrored.mean() == pytest.approx(share, abs=5 * np.sqrt(share / count))
    assert (reply.args["in"]["seed"] != many["seed"]).all()
    again = s.call_many("glass_color", count, many, it).result
    np.testing.assert_array_equal(again, reply.result)


def test_glass_hands_its_seed_on(s: Session, reference: Library) -> None:
    """Two faces in a row draw independently: the second goes on where the first stopped."""
    count = 4000
    glass, black = reference.zeros("material"), reference.zeros("material")
    glass["refraction_index"], glass["ks"] = 1.5, 0.5
    below = s.call("init_plane", 0, 1, 0, 5, glass).result
    ceiling = s.call("init_plane", 0, -1, 0, 5, black).result
    set_scene(s, np.array([below, ceiling]))
    set_options(s, fresnel=False, reflections=False)
    it, r = reference.zeros("intersection"), reference.zeros("ray", count)
    it["normal"], it["mat"] = (0, 1, 0), glass
    r["dir"], r["seed"] = (0, -1, 0), np.arange(count)
    colors = s.call_many("glass_color", count, r, it).result
    sky = (colors == SKY).all(axis=1)
    # Sky only for who goes through both faces: 1/4, and 1/2 if both drew the same number.
    assert sky.mean() == pytest.approx(1 / 4, abs=5 * np.sqrt(3 / 16 / count))
    np.testing.assert_array_equal(colors[~sky], 0)
