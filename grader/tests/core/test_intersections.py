"""Planes, spheres, cylinders and cones against closed forms, and at their edges."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from grader.execution.session import Library, Reply, Session
from grader.tests.core import oracles
from grader.tests.core.oracles import Array, dot, norm, unit
from grader.tests.core.worlds import garbage, inside, objects, rays, same_bytes

KINDS = ("plane", "sphere", "cylinder", "cone")
CASES = 3000
ORACLES: dict[str, Callable[[Array, Array], oracles.Crossings]] = {
    "plane": oracles.plane,
    "sphere": oracles.sphere,
    "cylinder": oracles.cylinder,
    "cone": oracles.cone,
}


def intersect(s: Session, kind: str, r: Array, it: Array, obj: Array) -> Reply:
    """Call intersect_KIND for each ray."""
    return s.call_many(f"intersect_{kind}", len(r), r, it, obj)


@pytest.mark.parametrize("kind", KINDS)
def test_random_rays_agree_with_closed_forms(
    s: Session, reference: Library, rng: np.random.Generator, kind: str
) -> None:
    """Hit or miss, t, position and normal are those of float64, whatever |dir|, tmin and tmax."""
    obj = objects(reference, rng, kind, CASES)
    r = rays(reference, rng, inside(rng, kind, obj))
    want = oracles.nearest(ORACLES[kind](r, obj), r["tmin"], r["tmax"])
    got = intersect(s, kind, r, garbage(reference, rng, "intersection", CASES), obj)
    assert want.clear.mean() > 0.9
    np.testing.assert_array_equal(got.result[want.clear], want.hit[want.clear])
    sure = want.clear & want.hit
    assert 0.2 < sure.mean() < 0.8
    way = r["dir"][sure].astype(float)
    cosine = np.abs(dot(unit(way), unit(want.normal[sure])))
    off = np.abs(got.args["r"]["tmax"][sure] - want.t[sure]) * norm(way)
    assert (off * cosine).max() < 5e-5
    position = r["orig"][sure] + want.t[sure][:, None] * way
    assert (norm(got.args["it"]["position"][sure] - position) * cosine).max() < 5e-5
    assert norm(got.args["it"]["normal"][sure] - want.normal[sure]).max() < 5e-3


@pytest.mark.parametrize("kind", KINDS)
def test_a_hit_lies_on_the_surface(
    s: Session, reference: Library, rng: np.random.Generator, kind: str
) -> None:
    """At orig + t dir, on the surface, t in range; normals unit, outwards; the rest is kept."""
    obj = objects(reference, rng, kind, CASES)
    r = rays(reference, rng, inside(rng, kind, obj))
    got = intersect(s, kind, r, garbage(reference, rng, "intersection", CASES), obj)
    hit = got.result
    new, it, solid = got.args["r"][hit], got.args["it"][hit], obj[hit]
    assert (new["tmax"] >= r["tmin"][hit]).all()
    assert (new["tmax"] <= r["tmax"][hit]).all()
    at_t = r["orig"][hit] + new["tmax"][:, None].astype(float) * r["dir"][hit]
    place, normal = it["position"].astype(float), it["normal"].astype(float)
    scale = 4 + norm(place)
    assert (norm(place - at_t) < 1e-6 * scale).all()
    assert (np.abs(oracles.depth_inside(kind, solid, place)) < 5e-6 * scale).all()
    np.testing.assert_allclose(norm(normal), 1, rtol=0, atol=1e-6)
    assert same_bytes(it["mat"], solid["mat"]).all()
    size = 1 if kind == "plane" else solid["radius"]
    step = 1e-3 * np.broadcast_to(size, hit.sum())[:, None]
    # Near an edge a step inwards may leave the solid through another face.
    assert (oracles.depth_inside(kind, solid, place + step * normal) < 0).all()
    assert (oracles.depth_inside(kind, solid, place - step * normal) > 0).mean() > 0.98
    expected = r[hit].copy()
    expected["tmax"] = new["tmax"]
    assert same_bytes(new, expected).all()


@pytest.mark.parametrize("kind", KINDS)
def test_nothing_is_skipped(
    s: Session, reference: Library, rng: np.random.Generator, kind: str
) -> None:
    """Between tmin and the hit, or tmax on a miss, a ray stays on one side of the surface."""
    obj = objects(reference, rng, kind, CASES)
    r = rays(reference, rng, inside(rng, kind, obj))
    r["tmax"] = np.minimum(r["tmax"], 20 / norm(r["dir"]))
    got = intersect(s, kind, r, garbage(reference, rng, "intersection", CASES), obj)
    share = np.linspace(0, 1, 41)[:, None]
    t = r["tmin"] + share * (got.args["r"]["tmax"].astype(float) - r["tmin"])
    places = r["orig"] + t[..., None] * r["dir"]
    depth = np.stack([oracles.depth_inside(kind, obj, each) for each in places])
    depth[np.abs(depth) < 1e-3] = 0
    assert not ((depth > 0).any(axis=0) & (depth < 0).any(axis=0)).any()


@pytest.mark.parametrize("kind", KINDS)
def test_a_miss_changes_nothing(
    s: Session, reference: Library, rng: np.random.Generator, kind: str
) -> None:
    """On a miss every byte of the ray and of the intersection stays."""
    obj = objects(reference, rng, kind, CASES)
    r = rays(reference, rng, inside(rng, kind, obj) + rng.normal(0, 1, (CASES, 3)))
    it = garbage(reference, rng, "intersection", CASES)
    got = intersect(s, kind, r, it, obj)
    missed = ~got.result
    assert missed.sum() > 1000
    assert same_bytes(got.args["r"], r)[missed].all()
    assert same_bytes(got.args["it"], it)[missed].all()
    assert not same_bytes(got.args["it"], it)[~missed].any()


@pytest.mark.parametrize("kind", KINDS)
def test_wild_numbers_give_no_nan(
    s: Session, reference: Library, rng: np.random.Generator, kind: str
) -> None:
    """Zero, tiny and huge directions, sizes, distances: a finite hit in range, or a clean miss."""
    obj = objects(reference, rng, kind, CASES)
    r = rays(reference, rng, inside(rng, kind, obj))
    r["dir"] *= 10 ** rng.uniform(-30, 16, (CASES, 1))
    r["dir"][::7] = 0
    r["dir"][::5, 1] = 0
    r["orig"] *= 10 ** rng.uniform(-9, 9, (CASES, 1))
    obj["radius"] *= 10 ** rng.uniform(-9, 9, CASES)
    r["tmin"], r["tmax"] = 0, 3e38
    it = garbage(reference, rng, "intersection", CASES)
    got = intersect(s, kind, r, it, obj)
    hit = got.result
    assert hit.sum() > 100
    assert not hit[::7].any()
    for values in (got.args["r"]["tmax"], got.args["it"]["position"], got.args["it"]["normal"]):
        assert np.isfinite(values[hit]).all()
    length = norm(got.args["it"]["normal"][hit].astype(float))
    np.testing.assert_allclose(length, 1, rtol=0, atol=1e-5)
    assert same_bytes(got.args["r"], r)[~hit].all()
    assert same_bytes(got.args["it"], it)[~hit].all()
