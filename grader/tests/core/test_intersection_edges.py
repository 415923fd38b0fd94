"""Where intersections go wrong: parallel, tangent, inside, on the surface, behind, out of range.

Every number is exact in float: a tangent ray is tangent.
"""

from __future__ import annotations

import numpy as np
import pytest

from grader.execution.session import Library, Session
from grader.tests.core.oracles import Array, norm
from grader.tests.core.worlds import directions, garbage, same_bytes

Vector = tuple[float, float, float]
Case = tuple[str, Vector, Vector, float, float, float | None, Vector]

X, Y, Z, ZERO = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
LEFT, DOWN, BACK = (-1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0)
FAR = 100.0

# What the ray is, origin, direction, tmin, tmax, then t (None: a miss) and normal.

# The plane y = 1; its normal is stored as (0, 2, 0) and given back as stored.
PLANE: list[Case] = [
    ("from above", (3, 5, 3), DOWN, 0, FAR, 4, (0, 2, 0)),
    ("from below, same normal", (0, -1, 0), Y, 0, FAR, 2, (0, 2, 0)),
    ("dir not unit", (0, 5, 0), (0, -8, 0), 0, FAR, 0.5, (0, 2, 0)),
    ("behind", (0, 5, 0), Y, 0, FAR, None, ZERO),
    ("parallel above", (0, 2, 0), X, 0, FAR, None, ZERO),
    ("parallel in the plane", (0, 1, 0), X, 0, FAR, None, ZERO),
    ("zero direction", (0, 5, 0), ZERO, 0, FAR, None, ZERO),
    ("zero direction in the plane", (0, 1, 0), ZERO, 0, FAR, None, ZERO),
    ("origin on the plane", (0, 1, 0), Y, 0, FAR, 0, (0, 2, 0)),
    ("origin on the plane, tmin beyond", (0, 1, 0), Y, 0.25, FAR, None, ZERO),
    ("at tmax", (0, 5, 0), DOWN, 0, 4, 4, (0, 2, 0)),
    ("at tmin", (0, 5, 0), DOWN, 4, FAR, 4, (0, 2, 0)),
    ("beyond tmax", (0, 5, 0), DOWN, 0, 3.75, None, ZERO),
    ("before tmin", (0, 5, 0), DOWN, 4.25, FAR, None, ZERO),
    ("negative tmin", (0, 5, 0), Y, -10, FAR, -4, (0, 2, 0)),
]
# The unit sphere around the origin.
SPHERE: list[Case] = [
    ("through the centre", (-5, 0, 0), X, 0, FAR, 4, LEFT),
    ("dir not unit", (-5, 0, 0), (4, 0, 0), 0, FAR, 1, LEFT),
    ("tangent", (-5, 1, 0), X, 0, FAR, 5, Y),
    ("just past", (-5, 1.0009765625, 0), X, 0, FAR, None, ZERO),
    ("behind", (5, 0, 0), X, 0, FAR, None, ZERO),
    ("from inside: second root, outward", (0, 0, 0), Y, 0, FAR, 1, Y),
    ("from inside, off the centre", (0.5, 0, 0), LEFT, 0, FAR, 1.5, LEFT),
    ("from the surface outwards", (1, 0, 0), X, 0, FAR, 0, X),
    ("from the surface outwards, tmin beyond", (1, 0, 0), X, 0.25, FAR, None, ZERO),
    ("from the surface inwards, tmin beyond", (1, 0, 0), LEFT, 0.25, FAR, 2, LEFT),
    ("tmin past the first root", (-5, 0, 0), X, 4.5, FAR, 6, X),
    ("tmin past both roots", (-5, 0, 0), X, 6.5, FAR, None, ZERO),
    ("tmax before the first root", (-5, 0, 0), X, 0, 3.5, None, ZERO),
    ("range between the roots", (-5, 0, 0), X, 4.5, 5.5, None, ZERO),
    ("at tmax", (-5, 0, 0), X, 0, 4, 4, LEFT),
    ("second root at tmin", (-5, 0, 0), X, 6, FAR, 6, X),
    ("zero direction outside", (-5, 0, 0), ZERO, 0, FAR, None, ZERO),
    ("zero direction inside", (0, 0, 0), ZERO, 0, FAR, None, ZERO),
    ("empty range", (-5, 0, 0), X, 5, 3, None, ZERO),
]
# Radius 1, from y = 0 to y = 2.
CYLINDER: list[Case] = [
    ("side", (-5, 1, 0), X, 0, FAR, 4, LEFT),
    ("side, dir not unit", (-5, 1, 0), (4, 0, 0), 0, FAR, 1, LEFT),
    ("upper disc", (0.5, 5, 0), DOWN, 0, FAR, 3, Y),
    ("lower disc", (0.5, -5, 0), Y, 0, FAR, 5, DOWN),
    ("along the axis", (0, 5, 0), DOWN, 0, FAR, 3, Y),
    ("parallel to the axis, beside it", (1.5, 5, 0), DOWN, 0, FAR, None, ZERO),
    ("above", (-5, 2.5, 0), X, 0, FAR, None, ZERO),
    ("below", (-5, -0.5, 0), X, 0, FAR, None, ZERO),
    ("tangent", (-5, 1, 1), X, 0, FAR, 5, Z),
    ("just past", (-5, 1, 1.0009765625), X, 0, FAR, None, ZERO),
    ("behind", (5, 1, 0), X, 0, FAR, None, ZERO),
    ("from inside to the side", (0, 1, 0), X, 0, FAR, 1, X),
    ("from inside to a disc", (0.5, 1, 0), Y, 0, FAR, 1, Y),
    ("from inside, downwards", (0.5, 1, 0), DOWN, 0, FAR, 1, DOWN),
    ("enters by a disc, leaves by the side", (0, 3, 0), (0.5, -1, 0), 1.25, FAR, 2, X),
    ("enters by the side past tmin, leaves by a disc", (-2, 1, 0), (2, 1, 0), 0.75, FAR, 1, Y),
    ("tmax before", (-5, 1, 0), X, 0, 3, None, ZERO),
    ("tmin past both", (-5, 1, 0), X, 6.5, FAR, None, ZERO),
    ("in the plane of a disc, above the solid", (-5, 3, 0), X, 0, FAR, None, ZERO),
    ("zero direction inside", (0, 1, 0), ZERO, 0, FAR, None, ZERO),
]
# Radius 1 at y = 0, apex at y = 1: the side has a slope of 45 degrees.
HALF = 0.5**0.5
CONE: list[Case] = [
    ("side", (-5, 0.5, 0), X, 0, FAR, 4.5, (-HALF, HALF, 0)),
    ("side from above", (0.5, 5, 0), DOWN, 0, FAR, 4.5, (HALF, HALF, 0)),
    ("dir not unit", (-5, 0.5, 0), (4, 0, 0), 0, FAR, 1.125, (-HALF, HALF, 0)),
    ("base", (0.5, -5, 0), Y, 0, FAR, 5, DOWN),
    ("base, along the axis", (0, -5, 0), Y, 0, FAR, 5, DOWN),
    ("apex, along the axis", (0, 5, 0), DOWN, 0, FAR, 4, Y),
    ("the mirrored half is not there", (-5, 1.5, 0), X, 0, FAR, None, ZERO),
    ("below", (-5, -0.5, 0), X, 0, FAR, None, ZERO),
    ("behind", (5, 0.5, 0), X, 0, FAR, None, ZERO),
    ("from inside to the side", (0, 0.25, 0), X, 0, FAR, 0.75, (HALF, HALF, 0)),
    ("from inside to the base", (0.25, 0.5, 0), DOWN, 0, FAR, 0.5, DOWN),
    ("from inside to the apex", (0, 0.5, 0), Y, 0, FAR, 0.5, Y),
    (
        "parallel to the side, from outside",
        (-2, 1.5, 0),
        (1, -1, 0),
        0,
        FAR,
        1.25,
        (-HALF, HALF, 0),
    ),
    ("parallel to the side, from inside", (0, 0.5, 0), (-1, 1, 0), 0, FAR, 0.25, (-HALF, HALF, 0)),
    ("beside, parallel to the axis", (1.5, 5, 0), DOWN, 0, FAR, None, ZERO),
    ("along the side, from above", (1, 2, 0), (-1, -1, 0), 0, FAR, 1, Y),
    ("tmin past the first", (-5, 0.5, 0), X, 5, FAR, 5.5, (HALF, HALF, 0)),
    ("tmax before", (-5, 0.5, 0), X, 0, 4, None, ZERO),
    ("zero direction inside", (0, 0.25, 0), ZERO, 0, FAR, None, ZERO),
]


def solid(s: Session, core: Library, kind: str) -> Array:
    """Return the object of the tables above."""
    mat = core.zeros("material")
    mat["kd"] = (0.25, 0.5, 0.75)
    if kind == "sphere":
        obj = s.call("init_sphere", 0, 0, 0, 1, mat).result
    elif kind == "plane":
        obj = s.call("init_plane", 0, 1, 0, -2, mat).result
        obj["normal"] = (0, 2, 0)
    else:
        length = 2 if kind == "cylinder" else 1
        obj = s.call(f"init_{kind}", ZERO, Y, length, 1, mat).result
    return np.asarray(obj)


@pytest.mark.parametrize(
    ("kind", "cases"),
    [("plane", PLANE), ("sphere", SPHERE), ("cylinder", CYLINDER), ("cone", CONE)],
)
def test_edges(
    s: Session, reference: Library, rng: np.random.Generator, kind: str, cases: list[Case]
) -> None:
    """Each case of the table gives its t and normal, or a miss that changes nothing."""
    r = reference.zeros("ray", len(cases))
    for row, (_, orig, way, tmin, tmax, _, _) in zip(r, cases, strict=True):
        row["orig"], row["dir"], row["tmin"], row["tmax"] = orig, way, tmin, tmax
    it = garbage(reference, rng, "intersection", len(cases))
    got = s.call_many(f"intersect_{kind}", len(cases), r, it, solid(s, reference, kind))
    unchanged = same_bytes(got.args["r"], r) & same_bytes(got.args["it"], it)
    for k, (name, orig, way, _, _, t, normal) in enumerate(cases):
        assert got.result[k] == (t is not None), name
        if t is None:
            assert unchanged[k], name
            continue
        assert got.args["r"]["tmax"][k] == pytest.approx(t, abs=1e-6), name
        new = got.args["it"][k]
        np.testing.assert_allclose(new["normal"], normal, atol=1e-6, err_msg=name)
        np.testing.assert_allclose(
            new["position"], np.add(orig, np.multiply(t, way)), atol=1e-6, err_msg=name
        )
        np.testing.assert_array_equal(new["mat"]["kd"], (0.25, 0.5, 0.75), err_msg=name)


def test_tiny_far_spheres_keep_their_shape(
    s: Session, reference: Library, rng: np.random.Generator
) -> None:
    """A sphere of radius 0.01 at 100 is hit within 0.9 radius of its centre, missed beyond 1.1.

    There b^2 - 4ac in float is off by several times the squared radius.
    """
    count, radius, distance = 2000, 0.01, 100.0
    way = directions(rng, count).astype(np.float32)
    aside = np.cross(way, directions(rng, count))
    aside *= rng.uniform(0, 2 * radius, (count, 1)) / norm(aside)[:, None]
    obj = reference.zeros("object", count)
    obj["type"], obj["radius"] = reference.constants["SPHERE"], radius
    obj["center"] = distance * way.astype(float) + aside
    r = reference.zeros("ray", count)
    r["dir"], r["tmax"] = way, 1000
    line = obj["center"].astype(float)
    passing = norm(line - (line * way).sum(axis=1)[:, None] * way.astype(float)) / radius
    got = s.call_many("intersect_sphere", count, r, reference.zeros("intersection", count), obj)
    assert got.result[passing < 0.99].all()
    assert not got.result[passing > 1.01].any()
    assert 0.3 < got.result.mean() < 0.7
