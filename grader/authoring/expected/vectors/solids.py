"""Rays for the intersection functions of TP2: planes, spheres, cylinders and cones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from grader.authoring.expected.vectors.maker import (
    Maker,
    Question,
    Recipe,
    joined,
    norm1,
    only,
    result,
)
from grader.checking.expected_data import Array, Batch

CASES = 160  # random ones of a suite, before those that graze are left out
TOLERANCE = 1e-3
REASON = (
    "float arithmetic with the direct form b^2 - 4ac, and double arithmetic, both stay ten times"
    " closer; inputs that graze an edge are left out"
)
EXACTNESS = (TOLERANCE, REASON)
Args = dict[str, Array]
Near = Callable[[Array, float], Array]  # points in (up to 1) and around each object


class Solid:
    """One type of object: its function, simple rays, and random objects with points in them."""

    def __init__(self, m: Maker, function: str, simple: Args, objects: Array, near: Near) -> None:
        self.m, self.function, self.simple = m, function, simple
        self.objects, self.near = objects, near

    def front(self) -> Batch:
        """Return rays from outside that hit."""
        return self.hits(joined(self.simple, self.aimed(0.9)))

    def meets(self) -> Batch:
        """Return rays that hit, pass by, or go away."""
        drawn = self.aimed(2.5)
        drawn["r"][::3] = _turned(drawn["r"][::3])
        return self.steady(joined(self.simple, self.passing(), drawn))

    def behind(self) -> Batch:
        """Return rays that leave the object behind them."""
        front = self.front()
        turned = replace(front, args={**front.args, "r": _turned(front.args["r"])})
        return only(turned, ~result(self.m.ask(turned)))

    def steady(self, args: Args) -> Batch:
        """Return the calls whose answer is clear."""
        return self.m.steady(self.batch(args), "r.orig")

    def hits(self, args: Args) -> Batch:
        """Return the calls that clearly hit."""
        batch = self.steady(args)
        return only(batch, result(self.m.ask(batch)))

    def batch(self, args: Args) -> Batch:
        """Return calls; `args` has rays and objects."""
        blank = self.m.blank("intersection", len(args["r"]))
        ordered = {"r": args["r"], "it": blank, "obj": args["obj"]}
        return Batch(self.function, ordered, {})

    def aimed(self, spread: float) -> Args:
        """Return rays from afar towards points in and around the objects."""
        target = self.near(self.objects, spread)
        away = self.m.unit(len(target)) * self.m.uniform(4, 9, len(target), 1)
        return {"r": self.m.rays(target + away, norm1(-away)), "obj": self.objects}

    def inside(self) -> Batch:
        """Return rays that start inside."""
        start = self.near(self.objects, 0.6)
        simple = {"r": self.simple["r"][:3].copy(), "obj": self.simple["obj"][:3]}
        simple["r"]["orig"] = self.near(simple["obj"], 0.0)
        drawn = {"r": self.m.rays(start, self.m.unit(len(start))), "obj": self.objects}
        return self.hits(joined(simple, drawn))

    def passing(self) -> Args:
        """Return the simple rays moved aside, so that they pass by."""
        rays = self.simple["r"].copy()
        aside = np.roll(np.abs(rays["dir"]), 1, axis=1)
        rays["orig"] += 5 * aside
        return {"r": rays, "obj": self.simple["obj"]}

    def ranges(self) -> Batch:
        """Return rays whose tmin or tmax leaves one, the other or none of the two hits."""
        front = self.front()
        first = self.m.ask(front).answers[0].out["r"]["tmax"]
        later = {**front.args, "r": front.args["r"].copy()}
        later["r"]["tmin"] = first + 0.25
        again = self.m.ask(replace(front, args=later))
        second = np.where(result(again), again.answers[0].out["r"]["tmax"], first + 1)
        rays, turn = front.args["r"].copy(), np.arange(front.count) % 5
        wide = second - first > 0.5
        bounds: list[tuple[Any, Any]] = [
            (0, first * 0.75),
            (0, first * 1.5),
            (first * 0.5, 1000),
            (np.where(wide, (first + second) / 2, first * 0.9), 1000),
            (np.where(wide, second + 1, first + 2), 1000),
        ]
        rays["tmin"] = np.choose(turn, [np.broadcast_to(low, turn.shape) for low, _ in bounds])
        rays["tmax"] = np.choose(turn, [np.broadcast_to(high, turn.shape) for _, high in bounds])
        return self.steady({"r": rays, "obj": front.args["obj"]})

    def scaled(self) -> Batch:
        """Return rays with directions that are not unit."""
        front = self.front()
        rays = front.args["r"].copy()
        factors = self.m.uniform(0.2, 5, front.count)
        factors[: len(self.simple["r"])] = 2
        rays["dir"] *= factors[:, None]
        return self.hits({"r": rays, "obj": front.args["obj"]})


EVERY = {
    "front": Solid.front,
    "meets": Solid.meets,
    "behind": Solid.behind,
    "range": Solid.ranges,
    "scaled": Solid.scaled,
}  # the suites that every solid has


def recipe(
    solid: Callable[[Maker], Solid], function: str, name: str, make: Callable[[Solid], Batch]
) -> Recipe:
    """Return a suite of a solid."""
    return Recipe(f"{function}.{name}", lambda m: [Question(make(solid(m)))], *EXACTNESS)


def _turned(rays: Array) -> Array:
    turned = rays.copy()
    turned["dir"] *= -1
    return turned


def spheres(m: Maker) -> Solid:
    """Return the sphere."""
    count = 4
    unit = m.objects("SPHERE", count, center=(0, 0, 0), radius=1)
    unit["center"][2], unit["radius"][2] = (0, 0, 3), 2
    starts = [(0, 0, 5), (4, 0, 0), (0, 0, 9), (0, 0.5, 5)]
    ways = [(0, 0, -1), (-1, 0, 0), (0, 0, -1), (0, 0, -1)]
    simple = {"r": m.rays(starts, ways), "obj": unit}
    center, radius = m.uniform(-3, 3, CASES, 3), m.uniform(0.3, 2, CASES)
    drawn = m.objects("SPHERE", CASES, center=center, radius=radius)

    def near(objects: Array, spread: float) -> Array:
        reach = m.uniform(0, 1, len(objects), 1) * objects["radius"][:, None]
        return np.asarray(objects["center"] + spread * reach * m.unit(len(objects)), np.float32)

    return Solid(m, "intersect_sphere", simple, drawn, near)


def planes(m: Maker) -> Solid:
    """Return the plane; a ray that is not parallel misses it only when it goes away from it."""
    flat = m.objects("PLANE", 4, normal=(0, 1, 0), dist=0)
    flat["dist"][2:] = (2, -1)
    starts = [(0, 3, 0), (0, -3, 0), (0, 1, 0), (0, 0, 0)]
    ways = [(0, -1, 0), (0, 1, 0), (0, -1, 0), (0.6, 0.8, 0)]
    simple = {"r": m.rays(starts, ways), "obj": flat}
    drawn = m.objects("PLANE", CASES, normal=m.unit(CASES), dist=m.uniform(-3, 3, CASES))

    def near(objects: Array, spread: float) -> Array:
        along = m.uniform(-4, 4, len(objects), 3)
        height = np.einsum("ij,ij->i", along, objects["normal"]) + objects["dist"]
        # Rays that run along the plane meet it far away, or not at all: as good as grazing.
        return np.asarray(along - height[:, None] * objects["normal"], np.float32)

    return Solid(m, "intersect_plane", simple, drawn, near)


def cylinders(m: Maker) -> Solid:
    """Return the cylinder."""
    return _tall(m, "CYLINDER", "intersect_cylinder")


def cones(m: Maker) -> Solid:
    """Return the cone."""
    return _tall(m, "CONE", "intersect_cone")


def _tall(m: Maker, kind: str, function: str) -> Solid:
    upright = m.objects(kind, 5, base=(0, 0, 0), axis=(0, 1, 0), length=2, radius=1)
    starts = [(0, 1, 5), (0, 5, 0), (0, -3, 0), (5, 0.5, 0), (0.25, -3, 0)]
    ways = [(0, 0, -1), (0, -1, 0), (0, 1, 0), (-1, 0, 0), (0, 1, 0)]
    simple = {"r": m.rays(starts, ways), "obj": upright}
    drawn = m.objects(
        kind,
        CASES,
        base=m.uniform(-3, 3, CASES, 3),
        axis=m.unit(CASES),
        length=m.uniform(0.8, 3, CASES),
        radius=m.uniform(0.4, 1.5, CASES),
    )

    def near(objects: Array, spread: float) -> Array:
        count = len(objects)
        along = 0.5 + spread * m.uniform(-0.5, 0.5, count, 1)
        wide = 1 - np.clip(along, 0, 1) if kind == "CONE" else np.ones((count, 1))
        side = norm1(np.cross(objects["axis"], m.unit(count)))
        out = spread * wide * m.uniform(0, 1, count, 1) * objects["radius"][:, None] * side
        up = along * objects["length"][:, None] * objects["axis"]
        return np.asarray(objects["base"] + up + out, np.float32)

    return Solid(m, function, simple, drawn, near)
