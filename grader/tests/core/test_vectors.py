"""vector.h, ray.h and the constructors, against numpy."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from grader.execution.session import Library, Session
from grader.tests.core.oracles import Array, dot, norm, reflected, unit
from grader.tests.core.worlds import directions, garbage, materials, same_bytes

CASES = 2000
BINARY: dict[str, Callable[[Array, Array], Array]] = {
    "vector_add": np.add,
    "vector_minus": np.subtract,
    "vector_vec_mul": np.multiply,
    "vector_min": np.minimum,
    "vector_max": np.maximum,
    "vector_cross": np.cross,
    "vector_dot": dot,
}


def vectors(rng: np.random.Generator, count: int = CASES) -> Array:
    """Return vectors whose lengths go from 1e-4 to 1e4."""
    lengths = 10 ** rng.uniform(-4, 4, (count, 1))
    return np.asarray(directions(rng, count) * lengths, np.float32)


@pytest.mark.parametrize("name", BINARY)
def test_operations_on_two_vectors(s: Session, rng: np.random.Generator, name: str) -> None:
    """Each component is float64's within the rounding of |a| |b|."""
    a, b = vectors(rng), vectors(rng)
    got = s.call_many(name, CASES, a, b).result
    want = BINARY[name](a.astype(float), b.astype(float))
    product = name in ("vector_cross", "vector_dot", "vector_vec_mul")
    scale = norm(a) * norm(b) if product else np.maximum(norm(a), norm(b))
    error = np.abs(got - want).reshape(CASES, -1).max(axis=1)
    assert (error <= 4e-7 * scale).all()


def test_vector_init_and_multiples(s: Session, rng: np.random.Generator) -> None:
    """Components stand where they should; f v is exact to the last bit."""
    v, f = vectors(rng), rng.normal(size=CASES).astype(np.float32)
    made = s.call_many("vector_init", CASES, v[:, 0], v[:, 1], v[:, 2]).result
    np.testing.assert_array_equal(made, v)
    np.testing.assert_array_equal(
        s.call_many("vector_float_mul", CASES, f, v).result, f[:, None] * v
    )


def test_lengths(s: Session, rng: np.random.Generator) -> None:
    """|v|, |v|^2 and v / |v|, from 1e-4 to 1e4."""
    v = vectors(rng)
    exact = norm(v.astype(float))
    np.testing.assert_allclose(s.call_many("vector_norm", CASES, v).result, exact, rtol=3e-7)
    np.testing.assert_allclose(s.call_many("vector_sqnorm", CASES, v).result, exact**2, rtol=5e-7)
    made = s.call_many("vector_normalized", CASES, v).result
    np.testing.assert_allclose(made, unit(v.astype(float)), rtol=0, atol=4e-7)


def test_a_vector_without_direction_stays_finite(s: Session) -> None:
    """The zero vector stays zero; what under- or overflows gives no NaN."""
    zeros = s.call_many("vector_normalized", 2, [(0, 0, 0), (-0.0, 0, -0.0)]).result
    np.testing.assert_array_equal(zeros, 0)
    extreme = [(1e-30, 0, 0), (0, 1e-38, 1e-45), (3e38, 3e38, 0), (1e20, -1e25, 1e30)]
    made = s.call_many("vector_normalized", 4, extreme).result
    assert np.isfinite(made).all()
    assert norm(made).max() <= 1.001


def test_vector_clamp(s: Session, rng: np.random.Generator) -> None:
    """Each component is brought into [lo, hi] and is otherwise kept exactly."""
    v = rng.normal(0, 2, (CASES, 3)).astype(np.float32)
    got = s.call_many("vector_clamp", CASES, v, -0.5, 1.25).result
    np.testing.assert_array_equal(got, np.clip(v, -0.5, 1.25))


def test_vector_reflect(s: Session, rng: np.random.Generator) -> None:
    """The part along n changes its sign, the length stays; |v| from 1e-4 to 1e4."""
    v, n = vectors(rng).astype(float), directions(rng, CASES)
    got = s.call_many("vector_reflect", CASES, v, n).result
    assert (norm(got - norm(v)[:, None] * reflected(v, n)) <= 1e-6 * norm(v)).all()


def test_ray_init_and_ray_at(s: Session, reference: Library, rng: np.random.Generator) -> None:
    """A new ray looks from 0 to RAY_TMAX, depth 0, seed 1; r(t) = orig + t dir."""
    orig, way = vectors(rng), vectors(rng)
    r = garbage(reference, rng, "ray", CASES)
    r = s.call_many("ray_init", CASES, r, orig, way).args["r"]
    np.testing.assert_array_equal(r["orig"], orig)
    np.testing.assert_array_equal(r["dir"], way)
    assert reference.constants["RAY_TMAX"] == 1000
    for name, value in {"tmin": 0, "tmax": 1000, "depth": 0, "seed": 1}.items():
        assert (r[name] == value).all(), name
    t = rng.uniform(-10, 10, CASES)
    want = orig + t[:, None] * way.astype(float)
    scale = norm(orig) + np.abs(t) * norm(way)
    assert (norm(s.call_many("ray_at", CASES, r, t).result - want) <= 4e-7 * scale).all()


def test_ray_random_is_uniform(s: Session, reference: Library) -> None:
    """In [0, 1), mean 1/2, variance 1/12, flat in 64 bins, neighbours unrelated."""
    count = 30_000
    r = reference.zeros("ray", count)
    r["seed"] = np.arange(count)
    reply = s.call_many("ray_random", count, r)
    x = reply.result.astype(float)
    assert (reply.args["r"]["seed"] != r["seed"]).all()
    assert x.min() >= 0
    assert x.max() < 1
    # Limits at five standard deviations of that many true random numbers.
    assert x.mean() == pytest.approx(1 / 2, abs=5 * np.sqrt(1 / 12 / count))
    assert x.var() == pytest.approx(1 / 12, abs=5 * np.sqrt(1 / 180 / count))
    bins = np.histogram(x, 64, (0, 1))[0]
    assert ((bins - count / 64) ** 2).sum() / (count / 64) < 63 + 5 * np.sqrt(2 * 63)
    assert abs(np.corrcoef(x[:-1], x[1:])[0, 1]) < 5 / np.sqrt(count)


def test_one_ray_draws_a_sequence(s: Session, reference: Library) -> None:
    """Numbers drawn one after the other from one ray differ, and are the same in each run."""
    drawn = []
    for _ in range(2):
        r, numbers = reference.zeros("ray"), []
        for _ in range(100):
            reply = s.call("ray_random", r)
            r = reply.args["r"]
            numbers.append(float(reply.result))
        drawn.append(numbers)
    assert drawn[0] == drawn[1]
    assert len(set(drawn[0])) == 100


def test_pixel_seeds_differ(s: Session) -> None:
    """No two pixels share the seed of their first sample, no two samples of a pixel theirs."""
    i, j = (each.ravel() for each in np.meshgrid(np.arange(160), np.arange(90)))
    for scale in (1, 200):
        seeds = s.call_many("pixel_seed", i.size, scale * i, scale * j, 0).result
        assert np.unique(seeds).size == i.size
    samples = np.arange(64 * 64)
    for place in (0, 719):
        seeds = s.call_many("pixel_seed", samples.size, place, place, samples).result
        assert np.unique(seeds).size == samples.size


def test_constructors(s: Session, reference: Library, rng: np.random.Generator) -> None:
    """Fields are kept, normals and axes are made unit, d and lengths are left as they are."""
    mats = materials(reference, rng, CASES)
    p, v = vectors(rng), vectors(rng)
    a, b = rng.uniform(0.1, 5, (2, CASES)).astype(np.float32)
    ball = s.call_many("init_sphere", CASES, *p.T, a, mats).result
    flat = s.call_many("init_plane", CASES, *v.T, a, mats).result
    tube = s.call_many("init_cylinder", CASES, p, v, a, b, mats).result
    hat = s.call_many("init_cone", CASES, p, v, a, b, mats).result
    for name, made in {"SPHERE": ball, "PLANE": flat, "CYLINDER": tube, "CONE": hat}.items():
        assert (made["type"] == reference.constants[name]).all()
        assert same_bytes(made["mat"], mats).all()
    np.testing.assert_array_equal(ball["center"], p)
    np.testing.assert_array_equal(ball["radius"], a)
    np.testing.assert_array_equal(flat["dist"], a)
    np.testing.assert_allclose(flat["normal"], unit(v.astype(float)), rtol=0, atol=4e-7)
    for made in (tube, hat):
        np.testing.assert_array_equal(made["base"], p)
        np.testing.assert_array_equal(made["length"], a)
        np.testing.assert_array_equal(made["radius"], b)
        np.testing.assert_allclose(made["axis"], unit(v.astype(float)), rtol=0, atol=4e-7)


def test_init_material(s: Session, rng: np.random.Generator) -> None:
    """Opaque, without pattern, kr = ks; nothing of it is left unset."""
    kd, ks = rng.random((2, CASES, 3)).astype(np.float32)
    mat = s.call_many("init_material", CASES, kd, ks, 20).result
    np.testing.assert_array_equal(mat["kd"], kd)
    np.testing.assert_array_equal(mat["ks"], ks)
    np.testing.assert_array_equal(mat["kr"], ks)
    assert (mat["shininess"] == 20).all()
    for name in ("refraction_index", "pattern", "user"):
        assert (mat[name] == 0).all(), name


def test_init_camera(s: Session, rng: np.random.Generator) -> None:
    """It looks along zdir; xdir = up x zdir, ydir = zdir x xdir, center = zdir / tan(fov / 2)."""
    position, at, up = rng.normal(0, 3, (3, CASES, 3)).astype(np.float32)
    fov, aspect = rng.uniform(5, 150, CASES), rng.uniform(0.5, 3, CASES)
    cam = s.call_many("init_camera", CASES, position, at, up, fov, aspect).result
    z = unit(at.astype(float) - position)
    x = unit(np.cross(up, z))
    sure = norm(np.cross(unit(up.astype(float)), z)) > 0.05
    assert sure.mean() > 0.95
    for name, want in {"zdir": z, "xdir": x, "ydir": np.cross(z, x)}.items():
        np.testing.assert_allclose(cam[name][sure], want[sure], rtol=0, atol=2e-5, err_msg=name)
    center = z / np.tan(np.radians(fov) / 2)[:, None]
    np.testing.assert_allclose(cam["center"], center, rtol=1e-5, atol=2e-5)
    np.testing.assert_allclose(cam["fov"], fov, rtol=1e-6)
    np.testing.assert_allclose(cam["aspect"], aspect, rtol=1e-6)
    np.testing.assert_array_equal(cam["position"], position)
