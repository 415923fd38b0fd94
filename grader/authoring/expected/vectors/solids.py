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
from grader.checking import describe
from grader.checking.expected_data import Array, Batch
from grader.intake.header_numbers import kinds

CASES = 160  # random ones of a suite, before those that graze are left out
TOLERANCE = 1e-3
LARGE = 512
TIP = 0.25  # of a cone's length
_LENGTHS = ("center", "base", "radius", "length", "dist")
REASON = (
    "float arithmetic with the direct form b^2 - 4ac, and double arithmetic, both stay ten times"
    " closer; inputs that graze an edge are left out"
)
EXACTNESS = (TOLERANCE, REASON)
Args = dict[str, Array]
Near = Callable[[Array, float], Array]  # points in (up to 1) and around each object


class Solid:
    """One type of object: its function, simple rays, and random objects with points in them."""

    def __init__(
        self,
        m: Maker,
        function: str,
        simple: Args,
        objects: Array,
        near: Near,
        is_plain: Callable[[Solid, Batch], Array] | None = None,
    ) -> None:
        self.m, self.function, self.simple = m, function, simple
        self.objects, self.near = objects, near
        self.is_plain = is_plain  # marks calls that no part of the solid's own decides

    def front(self) -> Batch:
        """Return rays from outside that hit, in the range that they have."""
        batch = self.new()
        first = self.m.ask(batch).answers[0].out["r"]["tmax"]
        used = self.m.used(batch.args["r"], len(self.simple["r"]), first, first)
        return replace(batch, args={**batch.args, "r": used})

    def new(self) -> Batch:
        """Return rays from outside, as ray_init makes them, that hit."""
        return self.plain(self.hits(joined(self.simple, self.aimed(0.9))))

    def meets(self) -> Batch:
        """Return rays that hit or pass by; a plane is only passed by along it."""
        args = joined(self.simple, self.passing(), self.aimed(2.5))
        args["r"]["depth"] = np.arange(len(args["r"])) % 5
        batch = self.plain(self.steady(args))
        flat = self.function == "intersect_plane"
        return only(batch, result(self.m.ask(batch))) if flat else batch

    def behind(self) -> Batch:
        """Return rays that leave the object behind them."""
        front = self.new()
        turned = replace(front, args={**front.args, "r": _turned(front.args["r"])})
        drawn = turned.args["r"][len(self.simple["r"]) :]
        drawn["depth"], drawn["tmin"] = 3, 0.25
        return only(turned, ~result(self.m.ask(turned)))

    def plain(self, batch: Batch) -> Batch:
        """Return the calls that ask about what all solids have in common."""
        return only(batch, self.is_plain(self, batch)) if self.is_plain else batch

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
        return self.plain(self.hits(joined(simple, drawn)))

    def passing(self) -> Args:
        """Return the simple rays moved aside, so that they pass by."""
        rays = self.simple["r"].copy()
        aside = np.roll(np.abs(rays["dir"]), 1, axis=1)
        rays["orig"] += 5 * aside
        return {"r": rays, "obj": self.simple["obj"]}

    def ranges(self) -> Batch:
        """Return rays whose tmin or tmax leaves one, the other or none of the two hits."""
        front = self.new()
        first = self.m.ask(front).answers[0].out["r"]["tmax"]
        later = {**front.args, "r": front.args["r"].copy()}
        later["r"]["tmin"] = first + 0.25
        again = self.m.ask(replace(front, args=later))
        second = np.where(result(again), again.answers[0].out["r"]["tmax"], first + 1)
        rays, turn = front.args["r"].copy(), np.arange(front.count) % 7
        wide = second - first > 0.5
        bounds: list[tuple[Any, Any]] = [
            (0, first * 0.75),
            (0, first * 1.5),
            (first * 0.5, 1000),
            (np.where(wide, (first + second) / 2, first * 0.9), 1000),
            (np.where(wide, second + 1, first + 2), 1000),
            (0, 1e5),  # these two with a t beyond 1000
            (0, 1000),
        ]
        rays["tmin"] = np.choose(turn, [np.broadcast_to(low, turn.shape) for low, _ in bounds])
        rays["tmax"] = np.choose(turn, [np.broadcast_to(high, turn.shape) for _, high in bounds])
        args = {"r": rays, "obj": front.args["obj"].copy()}
        _enlarge(args, turn >= 5)
        return self.plain(self.steady(args))

    def scaled(self) -> list[Batch]:
        """Return rays whose directions are not unit, then the same with unit ones."""
        front = self.new()
        rays = front.args["r"].copy()
        factors = self.m.uniform(1.5, 5, front.count)
        factors[: len(self.simple["r"])] = 2
        rays["dir"] *= factors[:, None]
        long = replace(front, args={**front.args, "r": rays})
        both = result(self.m.ask(long))
        return [only(long, both), only(front, both)]


EVERY: dict[str, Callable[[Solid], Batch | list[Batch]]] = {
    "front": Solid.front,
    "meets": Solid.meets,
    "behind": Solid.behind,
    "range": Solid.ranges,
    "scaled": Solid.scaled,
}  # the suites that every solid has


def recipe(
    solid: Callable[[Maker], Solid],
    function: str,
    name: str,
    make: Callable[[Solid], Batch | list[Batch]],
) -> Recipe:
    """Return a suite of a solid."""

    def questions(m: Maker) -> list[Question]:
        made = make(solid(m))
        batches = made if isinstance(made, list) else [made]
        return [Question(_off_the_tip(m, each)) for each in batches]

    return Recipe(f"{function}.{name}", questions, *EXACTNESS)


def _off_the_tip(m: Maker, batch: Batch) -> Batch:
    """Return the calls but those that meet a cone at its tip: a rounding turns the normal there."""
    if batch.function != "intersect_cone":
        return batch
    cone, answer = batch.args["obj"], m.ask(batch).answers[0]
    tip = cone["base"] + cone["axis"] * cone["length"][:, None]
    away = np.linalg.norm(answer.out["it"]["position"] - tip, axis=1)
    return only(batch, (answer.result == 0) | (away > TIP * cone["length"]))


def _enlarge(args: Args, where: Array) -> None:
    """Make rays and objects larger, by a power of 2: rounding stays as it is."""
    factor = np.where(where, LARGE, 1).astype(np.float32)
    kind = describe.OBJECTS[kinds()[int(args["obj"]["type"][0])]]
    parts = [(args["r"], "orig"), *((args["obj"], name) for name in kind if name in _LENGTHS)]
    for table, name in parts:
        column = table[name]
        table[name] = column * factor.reshape(-1, *[1] * (column.ndim - 1))


def _turned(rays: Array) -> Array:
    turned = rays.copy()
    turned["dir"] *= -1
    return turned
