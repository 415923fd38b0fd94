"""What the core's functions must give, in float64 closed forms that owe nothing to the C code.

Points and directions have shape (n, 3); a number for each of n rays has shape (n,). A ray is
orig + t dir, t in units of dir.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]


def dot(a: Array, b: Array) -> Array:
    """Return the dot products of two lists of vectors."""
    return np.asarray((a * b).sum(axis=-1))


def norm(v: Array) -> Array:
    """Return the lengths of vectors."""
    return np.sqrt(dot(v, v))


def unit(v: Array) -> Array:
    """Return v / |v|; a zero vector stays zero."""
    length = norm(v)[..., None]
    return np.asarray(np.divide(v, length, out=np.zeros_like(v), where=length > 0))


def across(v: Array, axis: Array) -> Array:
    """Return v without its part along a unit axis."""
    return np.asarray(v - dot(v, axis)[..., None] * axis)


@dataclass(frozen=True)
class Crossings:
    """Where n rays cross the k pieces of a surface.

    t has shape (k, n) and outward unit `normal` (k, n, 3). `slack` (k, n) is positive where the
    crossing is real and lies within the piece, negative where not; close to zero the answer hangs
    on rounding.
    """

    t: Array
    normal: Array
    slack: Array


@dataclass(frozen=True)
class Nearest:
    """The nearest crossings in [tmin, tmax]: t (n,), normal (n, 3), and which rays hit.

    `clear` tells the rays for which rounding cannot change the answer.
    """

    hit: Array
    t: Array
    normal: Array
    clear: Array


def nearest(found: Crossings, tmin: Array, tmax: Array, tolerance: float = 1e-3) -> Nearest:
    """Choose the smallest t in range among the real crossings."""
    with np.errstate(invalid="ignore"):
        width = tolerance * np.maximum(1e-3, np.abs(found.t))
        real = (found.slack > 0) & np.isfinite(found.t)
        in_range = (found.t >= tmin) & (found.t <= tmax)
        at_the_end = (np.abs(found.t - tmin) < width) | (np.abs(found.t - tmax) < width)
    unsure = (np.abs(found.slack) < tolerance) | (real & at_the_end)
    t = np.where(real & in_range, found.t, np.inf)
    first = t.argmin(axis=0)
    columns = np.arange(t.shape[1])
    hit = np.isfinite(t[first, columns])
    return Nearest(hit, t[first, columns], found.normal[first, columns], ~unsure.any(axis=0))


def plane(ray: Array, obj: Array) -> Crossings:
    """Return the crossing of each ray with its plane p.normal + dist = 0."""
    orig, way, normal = (each.astype(float) for each in (ray["orig"], ray["dir"], obj["normal"]))
    slope = dot(way, normal)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = -(dot(orig, normal) + obj["dist"]) / slope
    slack = np.abs(slope) / np.maximum(norm(way), 1e-300)
    return Crossings(t[None], normal[None], slack[None])


def _circle(o: Array, d: Array, radius: Array) -> tuple[Array, Array, Array]:
    """Return the two t with |o + t d| = radius, and the slack: 1 - (nearest distance / radius)."""
    d_d = dot(d, d)
    with np.errstate(divide="ignore", invalid="ignore"):
        middle = -dot(o, d) / d_d
        passing = norm(o + middle[:, None] * d)
        half = np.sqrt(np.maximum(radius**2 - passing**2, 0) / d_d)
    slack = np.where(d_d > 0, 1 - passing / radius, -1)
    return middle - half, middle + half, slack


def sphere(ray: Array, obj: Array) -> Crossings:
    """Return the two crossings of each ray with its sphere."""
    o = ray["orig"].astype(float) - obj["center"]
    way = ray["dir"].astype(float)
    t1, t2, slack = _circle(o, way, obj["radius"].astype(float))
    normals = [unit(o + t[:, None] * way) for t in (t1, t2)]
    return Crossings(np.stack([t1, t2]), np.stack(normals), np.stack([slack, slack]))


def _disc(o: Array, way: Array, normal: Array, radius: Array) -> tuple[Array, Array]:
    """Return t and slack on a disc round the zero point."""
    with np.errstate(divide="ignore", invalid="ignore"):
        t = -dot(o, normal) / dot(way, normal)
        slack = 1 - norm(o + t[:, None] * way) / radius
    return t, np.where(np.isfinite(slack), slack, -1)


def _side_slack(height: Array, length: Array, slack: Array) -> Array:
    """Return the slack of a side of which only heights from 0 to length exist."""
    share = height / length
    with np.errstate(invalid="ignore"):
        inside = np.minimum(np.minimum(share, 1 - share), slack)
    return np.where(np.isfinite(inside), inside, -1)


def cylinder(ray: Array, obj: Array) -> Crossings:
    """Return the crossings with side (two) and discs (two) of each ray's cylinder."""
    axis, radius = obj["axis"].astype(float), obj["radius"].astype(float)
    length = obj["length"].astype(float)
    way = ray["dir"].astype(float)
    o = ray["orig"].astype(float) - obj["base"]
    t1, t2, slack = _circle(across(o, axis), across(way, axis), radius)
    times, normals, slacks = [], [], []
    for t in (t1, t2):
        p = o + np.where(np.isfinite(t), t, 0)[:, None] * way
        times.append(t)
        normals.append(unit(across(p, axis)))
        slacks.append(_side_slack(dot(p, axis), length, slack))
    for end, normal in ((o, -axis), (o - length[:, None] * axis, axis)):
        t, inside = _disc(end, way, normal, radius)
        times.append(t)
        normals.append(normal)
        slacks.append(inside)
    return Crossings(np.stack(times), np.stack(normals), np.stack(slacks))


def cone(ray: Array, obj: Array) -> Crossings:
    """Return the crossings with side (two) and disc of each ray's cone.

    The side holds the p with angle(p - apex, -axis) = atan(radius / length): with m the unit
    vector -axis and k = cos^2 of it, (p.m)^2 = k p.p, a quadratic in t.
    """
    length, radius = obj["length"].astype(float), obj["radius"].astype(float)
    m, way = -obj["axis"].astype(float), ray["dir"].astype(float)
    from_base = ray["orig"].astype(float) - obj["base"]
    o = from_base + length[:, None] * m
    k = length**2 / (length**2 + radius**2)
    a = dot(way, m) ** 2 - k * dot(way, way)
    b = dot(way, m) * dot(o, m) - k * dot(way, o)
    c = dot(o, m) ** 2 - k * dot(o, o)
    disc = b * b - a * c
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(np.maximum(disc, 0))
        slack = disc / (b * b + np.abs(a * c)) * np.minimum(1, 10 * np.abs(a) / dot(way, way))
        times = [(-b - root) / a, (-b + root) / a]
    normals, slacks = [], []
    for t in times:
        p = o + np.where(np.isfinite(t), t, 0)[:, None] * way
        # Away from the axis, tilted towards the apex by the angle of the side.
        outwards = length[:, None] * unit(across(p, m)) - radius[:, None] * m
        normals.append(unit(outwards))
        slacks.append(_side_slack(dot(p, m), length, slack))
    t, inside = _disc(from_base, way, m, radius)
    return Crossings(np.stack([*times, t]), np.stack([*normals, m]), np.stack([*slacks, inside]))


def depth_inside(kind: str, obj: Array, p: Array) -> Array:
    """Return how deep points lie inside solids: 0 on the surface, negative outside.

    Only the sign and the zero set matter: the number is a bound of the distance to the surface.
    """
    if kind == "sphere":
        return np.asarray(obj["radius"] - norm(p - obj["center"].astype(float)))
    if kind == "plane":
        return np.asarray(-dot(p, obj["normal"].astype(float)) - obj["dist"])
    axis, length = obj["axis"].astype(float), obj["length"].astype(float)
    radius = obj["radius"].astype(float)
    q = p - obj["base"].astype(float)
    height, away = dot(q, axis), norm(across(q, axis))
    if kind == "cylinder":
        return np.asarray(np.minimum(np.minimum(height, length - height), radius - away))
    slant = (radius * (length - height) - length * away) / np.hypot(radius, length)
    return np.asarray(np.minimum(height, slant))


def schlick(kr: Array, cosine: Array) -> Array:
    """Return Schlick's kr + (1 - kr)(1 - cos)^5; kr (n, 3), cosine (n,), clamped to [0, 1]."""
    x = 1 - np.clip(cosine, 0, 1)[..., None]
    return np.asarray(kr + (1 - kr) * x**5)


def blinn_phong(n: Array, v: Array, way: Array, mat: Array, fresnel: bool) -> Array:
    """Return the handout's equation (1) for a white light in the direction `way`.

    With `fresnel`, Schlick of h.v stands for ks.
    """
    h = unit(way + v)
    specular = schlick(mat["kr"], dot(h, v)) if fresnel else mat["ks"].astype(float)
    s = mat["shininess"].astype(float)[..., None]
    lobe = np.maximum(dot(h, n), 0)[..., None] ** s * (s + 8) / (8 * np.pi)
    return np.asarray(np.maximum(dot(n, way), 0)[..., None] * (mat["kd"] / np.pi + lobe * specular))


def reflected(d: Array, n: Array) -> Array:
    """Return the unit mirror directions: the part along n changes its sign."""
    return unit(across(d, n) - dot(d, n)[..., None] * n)


def refracted(d: Array, n: Array, index: Array) -> tuple[Array, Array]:
    """Return the refracted unit directions, from the angles, and sin of the angle of refraction.

    The component along the surface is sin(t) = sin(i) n1 / n2 (Snell), the rest cos(t) across it.
    """
    d = unit(d)
    inside = dot(d, n) > 0
    along = across(d, n)
    sine = np.where(inside, index, 1 / index) * norm(along)
    cosine = np.sqrt(np.maximum(1 - sine**2, 0))
    side = np.where(inside, 1, -1)
    return sine[:, None] * unit(along) + (cosine * side)[:, None] * n, sine
