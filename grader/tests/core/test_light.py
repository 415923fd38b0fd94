"""Light and matter: shade, direct_light, the patterns, Fresnel; against their formulas."""

from __future__ import annotations

import numpy as np
import pytest

from grader.execution.session import Library, Session
from grader.tests.core import oracles
from grader.tests.core.oracles import Array, dot, norm, unit
from grader.tests.core.worlds import (
    directions,
    materials,
    set_lights,
    set_options,
    set_scene,
    set_texture,
)

CASES = 3000
WHITE = (1.0, 1.0, 1.0)


def hemisphere(rng: np.random.Generator, n: Array) -> Array:
    """Return directions of which most are on the side of n, as float holds them."""
    d = directions(rng, len(n))
    flip = np.where((dot(d, n) < 0) & (rng.random(len(n)) < 0.8), -1, 1)
    return np.asarray(d * flip[:, None], np.float32)


@pytest.mark.parametrize("fresnel", [False, True])
def test_shade_is_blinn_phong(
    s: Session, reference: Library, rng: np.random.Generator, fresnel: bool
) -> None:
    """Equation (1), with ks or Schlick in the lobe; black when the light is behind."""
    set_options(s, fresnel=fresnel)
    mat = materials(reference, rng, CASES)
    n = directions(rng, CASES).astype(np.float32)
    v, light_way = hemisphere(rng, n), hemisphere(rng, n)
    color = rng.uniform(0, 2, (CASES, 3))
    got = s.call_many("shade", CASES, n, v, light_way, color, mat).result
    n, v, light_way = (each.astype(float) for each in (n, v, light_way))
    want = color * oracles.blinn_phong(n, v, light_way, mat, fresnel)
    behind = dot(n, light_way) < -1e-6
    assert 0.05 < behind.mean() < 0.5
    assert (got[behind] == 0).all()
    # A power of 500 makes 500 times the rounding of h.n.
    np.testing.assert_allclose(got, want, rtol=2e-4, atol=2e-5)


def test_shade_at_its_edges(s: Session, reference: Library) -> None:
    """Grazing, opposite and behind: black or finite; h.n below zero counts as zero."""
    mat = reference.zeros("material")
    mat["kd"], mat["ks"], mat["kr"], mat["shininess"] = 0.5, 0.5, 0.5, 10
    up, side = (0, 1, 0), (1, 0, 0)
    for light_way in (side, (0, -1, 0), (0, 0, 0)):
        np.testing.assert_array_equal(s.call("shade", up, up, light_way, WHITE, mat).result, 0)
    # v = -l: there is no half vector, the lobe is dark, and the diffuse part stays.
    opposite = s.call("shade", up, (0, -1, 0), up, WHITE, mat).result
    np.testing.assert_allclose(opposite, 0.5 / np.pi, rtol=1e-6)
    slant = (0.6, 0.8, 0)
    below = s.call("shade", up, (-0.6, -0.9, 0), slant, WHITE, mat).result
    np.testing.assert_allclose(below, 0.8 * 0.5 / np.pi, rtol=1e-6)
    for shininess in (0, 0.01, 500, 1e6):
        mat["shininess"] = shininess
        assert np.isfinite(s.call("shade", up, (0, -1, 0), up, WHITE, mat).result).all()
        straight = s.call("shade", up, up, up, WHITE, mat).result
        specular = (shininess + 8) / (8 * np.pi) * 0.5
        np.testing.assert_allclose(straight, 0.5 / np.pi + specular, rtol=1e-5)


def test_direct_light_adds_the_lights(
    s: Session, reference: Library, rng: np.random.Generator
) -> None:
    """The sum of equation (1) over the lights, which do not fade; an empty scene bars nothing."""
    places, colors = rng.uniform(-9, 9, (3, 3)), rng.random((3, 3))
    set_scene(s, reference.zeros("object", 0))
    it = reference.zeros("intersection", CASES)
    it["mat"], it["normal"] = materials(reference, rng, CASES), directions(rng, CASES)
    it["position"] = rng.uniform(-2, 2, (CASES, 3))
    v = hemisphere(rng, it["normal"])
    for count in range(4):
        set_lights(s, reference, places[:count], colors[:count])
        want = np.zeros((CASES, 3))
        for place, color in zip(places[:count], colors[:count], strict=True):
            light_way = unit(place - it["position"].astype(float))
            want += color * oracles.blinn_phong(it["normal"], v, light_way, it["mat"], True)
        got = s.call_many("direct_light", CASES, it, v).result
        np.testing.assert_allclose(got, want, rtol=5e-4, atol=1e-4)


def test_direct_light_leaves_out_shadows(s: Session, reference: Library) -> None:
    """A light behind a sphere adds nothing, unless shadows are off; one at the point is dark."""
    ball = s.call("init_sphere", 0, 5, 0, 1, reference.zeros("material")).result
    set_scene(s, np.array([ball]))
    it = reference.zeros("intersection")
    it["normal"], it["mat"]["kd"] = (0, 1, 0), 1
    for place, lit in {(0, 10, 0): False, (0, 3, 0): True, (9, 1, 0): True}.items():
        set_lights(s, reference, np.array([place]), np.ones((1, 3)))
        for shadows in (True, False):
            set_options(s, shadows=shadows)
            got = s.call("direct_light", it, (0, 1, 0)).result
            assert (got > 0).all() == (lit or not shadows)
    set_lights(s, reference, np.zeros((1, 3)), np.ones((1, 3)))
    np.testing.assert_array_equal(s.call("direct_light", it, (0, 1, 0)).result, 0)


def test_checker_color(s: Session, reference: Library, rng: np.random.Generator) -> None:
    """Cubes in turn from pattern_origin, on its negative side too."""
    mat = materials(reference, rng, CASES)
    mat["pattern_origin"] = rng.uniform(-1, 1, (CASES, 3))
    mat["pattern_size"] = 10 ** rng.uniform(-1.5, 1, CASES)
    p = rng.uniform(-5, 5, (CASES, 3)).astype(np.float32)
    cube = (p.astype(float) - mat["pattern_origin"]) / mat["pattern_size"].astype(float)[:, None]
    even = np.floor(cube).sum(axis=1) % 2 == 0
    sure = np.abs(cube - np.round(cube)).min(axis=1) > 1e-3
    got = s.call_many("checker_color", CASES, mat, p).result
    want = np.where(even[:, None], mat["kd"], mat["kd2"])
    np.testing.assert_array_equal(got[sure], want[sure])
    assert (cube[sure] < 0).any(axis=1).mean() > 0.5
    assert 0.4 < even[sure].mean() < 0.6


def test_checker_color_at_the_corners(s: Session, reference: Library) -> None:
    """The cube that starts at the origin is kd, and has its lower faces."""
    mat = reference.zeros("material")
    mat["kd"], mat["kd2"], mat["pattern_size"] = 1, 0.25, 0.5
    places = [(0, 0, 0), (0.5, 0, 0), (0.5, 0.5, 0), (-0.25, 0, 0), (-0.25, -0.25, -0.25)]
    got = s.call_many("checker_color", 5, mat, places).result
    np.testing.assert_array_equal(got[:, 0], [1, 0.25, 1, 0.25, 0.25])
    far = s.call_many("checker_color", 2, mat, [(1e30, -1e30, 3e38), (1e8, 7, 7)]).result
    assert np.isin(far, (1, 0.25)).all()


def test_texture_color(s: Session, reference: Library, rng: np.random.Generator) -> None:
    """Longitude from left to right, from -z on; latitude from the north pole down; any distance."""
    width, height = 24, 12
    texels = rng.random((height, width, 3)).astype(np.float32)
    set_texture(s, reference, texels)
    mat = materials(reference, rng, CASES)
    mat["pattern_origin"] = rng.uniform(-2, 2, (CASES, 3))
    p = mat["pattern_origin"] + rng.uniform(0.1, 5, (CASES, 1)) * directions(rng, CASES)
    p = p.astype(np.float32)
    d = unit(p.astype(float) - mat["pattern_origin"])
    u = (0.5 + np.arctan2(d[:, 0], d[:, 2]) / (2 * np.pi)) * width
    v = np.arccos(np.clip(d[:, 1], -1, 1)) / np.pi * height
    sure = (np.abs(u - np.round(u)) > 1e-3) & (np.abs(v - np.round(v)) > 1e-3)
    got = s.call_many("texture_color", CASES, mat, p).result
    want = texels[np.floor(v).astype(int) % height, np.floor(u).astype(int) % width]
    assert sure.mean() > 0.95
    np.testing.assert_array_equal(got[sure], want[sure])


def test_texture_color_at_poles_seam_and_centre(s: Session, reference: Library) -> None:
    """Poles, both sides of the seam, the centre, an image of one texel, none: always a colour."""
    mat = reference.zeros("material")
    mat["kd"] = 0.125
    places = [(0, 2, 0), (0, -2, 0), (0.0, 0, -1), (-0.0, 0, -1), (1e-9, 0, -1), (0, 0, 0)]
    none = s.call_many("texture_color", len(places), mat, places).result
    np.testing.assert_array_equal(none, 0.125)
    rows = np.repeat(np.arange(1, 4, dtype=np.float32)[:, None] / 4, 8, axis=1)
    set_texture(s, reference, np.repeat(rows[..., None], 3, axis=2))
    got = s.call_many("texture_color", len(places), mat, places).result[:, 0]
    np.testing.assert_array_equal(got[:5], [0.25, 0.75, 0.5, 0.5, 0.5])
    assert got[5] in (0.25, 0.5, 0.75)
    set_texture(s, reference, np.full((1, 1, 3), 0.5))
    single = s.call_many("texture_color", len(places), mat, places).result
    np.testing.assert_array_equal(single, 0.5)


def test_reflectance(s: Session, rng: np.random.Generator) -> None:
    """((n1 - n2) / (n1 + n2))^2: 4 % for glass, nothing between equals, symmetric."""
    n1, n2 = rng.uniform(0.2, 4, (2, CASES)).astype(np.float32)
    exact = (n1.astype(float) - n2) ** 2 / (n1.astype(float) + n2) ** 2
    got = s.call_many("reflectance", CASES, n1, n2).result
    np.testing.assert_allclose(got, exact, rtol=1e-5, atol=1e-7)
    np.testing.assert_array_equal(got, s.call_many("reflectance", CASES, n2, n1).result)
    assert s.call("reflectance", 1, 1.5).result == pytest.approx(0.04)
    assert s.call("reflectance", 1.3, 1.3).result == 0


def test_fresnel_schlick(s: Session, rng: np.random.Generator) -> None:
    """Each channel for itself, between kr and white, n.v kept in [0, 1]."""
    kr = rng.random((CASES, 3)).astype(np.float32)
    n = directions(rng, CASES).astype(np.float32)
    v = hemisphere(rng, n)
    cosine = dot(n.astype(float), v)
    got = s.call_many("fresnel_schlick", CASES, kr, n, v).result
    np.testing.assert_allclose(got, oracles.schlick(kr, cosine), rtol=0, atol=2e-6)
    assert (cosine < 0).mean() > 0.05
    assert (got[cosine < 0] == 1).all()
    assert got.min() >= kr.min()
    straight = s.call_many("fresnel_schlick", CASES, kr, n, n).result
    np.testing.assert_allclose(straight, kr, rtol=0, atol=1e-6)
    assert norm(v.astype(float)).max() < 1.001
