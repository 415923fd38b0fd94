"""Calls whose rays bounce: those are kept that every right program answers alike.

Between balls, two rays that start side by side are thrown further apart at each bounce: after some,
two right ways of starting the first of them see two colours. And where light grazes, a place that
rounding has put under the surface is in its own shadow. Such calls answer otherwise when all of it
is moved far from the origin, where the roundings of the reference are as large as those of the
textbook's formulas are nearer.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from grader.authoring.expected.vectors.maker import Maker, Question, only
from grader.checking.comparison import far
from grader.checking.expected_data import Array, Batch
from grader.intake.header_numbers import header_number

# The point where the rays of a function start: parameter, field.
START_OF = {"trace_ray": ("r", "orig"), "mirror_color": ("it", "position")}
FAR = 400.0
TRIES = 6


def clear(maker: Maker, question: Question, tolerance: float) -> Question:
    """Return the calls that are answered alike wherever they are made, at each accepted stage.

    Alike is within the tolerance; it is of trace_ray or mirror_color.
    """
    name, field = START_OF[question.batch.function]
    every = (question.batch, *question.variants)
    keep = np.ones(question.batch.count, bool)
    for stage in every:
        base = _colors(maker, stage)
        for way in maker.unit(TRIES):
            other = shifted(maker, stage, FAR * way)
            other.args[name][field] += header_number("EPSILON") * maker.unit(other.count)
            keep &= ~far(_colors(maker, other), base, tolerance)
    kept, *others = (only(each, keep) for each in every)
    return Question(kept, tuple(others))


def _colors(maker: Maker, batch: Batch) -> Array:
    answered = maker.ask(replace(batch, answers=())).answers[0].result
    assert answered is not None
    return answered


def shifted(maker: Maker, batch: Batch, by: Array) -> Batch:
    """Return the same calls in the same scene, all of it moved by a vector."""
    args = {name: each.copy() for name, each in batch.args.items()}
    settings = {name: each.copy() for name, each in batch.globals.items()}
    for ray in (each for each in args.values() if "orig" in (each.dtype.names or ())):
        ray["orig"] += by
    for hit in (each for each in args.values() if "mat" in (each.dtype.names or ())):
        hit["position"] += by
        hit["mat"]["pattern_origin"] += by
    settings["lights"]["position"] += by
    _move(maker, settings["scene"], by)
    return replace(batch, args=args, globals=settings)


def _move(maker: Maker, scene: Array, by: Array) -> None:
    """Move objects; a plane is the points p with p.normal + dist = 0."""
    scene["mat"]["pattern_origin"] += by
    kinds = {name: scene["type"] == int(maker.core.constants[name]) for name in ("SPHERE", "PLANE")}
    others = ~(kinds["SPHERE"] | kinds["PLANE"])
    scene["center"][kinds["SPHERE"]] += by
    scene["base"][others] += by
    planes = kinds["PLANE"]
    scene["dist"][planes] -= scene["normal"][planes] @ by
