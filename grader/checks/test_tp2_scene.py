"""TP2 - rays and objects: the nearest object of a scene, the colour along a ray."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from grader.checking.expected_data import Answer, Array, Batch
from grader.checking.student import Answers, Bench, Student, Wrong
from grader.checks.common import (
    Alone,
    check_last_stage,
    met_alone,
    with_options,
)

# ---- TP2.5: intersect_scene ---------------------------------------------------------------------


@pytest.mark.check("tp2.intersect_scene.every")
def test_intersect_scene_every(student: Student) -> None:
    """Every object counts, from the first to the last."""
    for trial in student.trials("intersect_scene.every"):
        trial.expect("result")
        trial.expect("it.mat.kd", where=~trial.refused)


@pytest.mark.check("tp2.intersect_scene.kinds")
def test_intersect_scene_kinds(student: Student) -> None:
    """Objects of all kinds count, by intersect_object, in whatever order they stand."""
    for trial, alone in scene_by_objects(student):
        trial.expect("result", where=alone.sound)
        one = alone.sound & (alone.count == 1)
        trial.expect("r.tmax", where=one)
        trial.expect("it.mat.kd", "it.normal", where=one & alone.kept)


def scene_by_objects(student: Student) -> Iterator[tuple[Answers, Alone]]:
    """Yield the answers to a suite, to be judged by those of the submission's intersect_object.

    So an object that it does not know yet is missing on both sides, and one that it meets wrongly
    is another check's question; so is, of several that are met, which one is the nearest.
    """
    for batch in student.batches("intersect_scene.kinds"):
        with student.bench() as bench:
            trial = bench.trial(batch)
            alone = met_alone(bench, batch, batch.args["r"])
        if not (alone.sound & (alone.count > 0)).any():  # nothing is met yet
            trial.expect("result", "r.tmax")
        own = Answer(alone.count > 0, {"r": alone.rays, "it": alone.hits})
        yield replace(trial, batch=replace(batch, answers=(own,))), alone


# ---- TP2.6: trace_ray ---------------------------------------------------------------------------


@pytest.mark.check("tp2.trace_ray.lit")
def test_trace_ray_lit(student: Student) -> None:
    """With lights and mirrors too, the colour is what hit_color says."""
    check_glue(student, "trace_ray.lit")


@pytest.mark.check("tp2.trace_ray.pattern")
def test_trace_ray_pattern(student: Student) -> None:
    """What is hit is asked of nearest_hit, which knows patterns and the octree."""
    check_glue(student, "trace_ray.pattern")


def check_glue(student: Student, suite: str) -> None:
    """Compare colours with those that the glue makes of the submission's own functions."""
    for batch in student.batches(suite):
        with student.bench() as bench:
            bench.prepare(batch)
            bench.call("scene_changed", "scene_changed()")
            trial = bench.again(batch)
            own = by_the_glue(bench, batch)
            # What is black without lights too has bounced too often: another check's question.
            bench.prepare(with_options(batch, shading=False))
            judged = np.asarray(bench.again(batch).got("result").any(axis=1))
        judged &= np.isfinite(own).all(axis=1)  # what is no number equals nothing, itself included
        # Who does all of it in trace_ray gives what the reference gives.
        accepted = (Answer(own, trial.answer.out), *batch.answers)
        trial = replace(trial, batch=replace(batch, answers=accepted))
        try:
            trial.expect("result", where=judged)
        except Wrong as first:
            check_last_stage(student, suite, first)


def by_the_glue(bench: Bench, batch: Batch) -> Array:
    """Return the colours that the glue makes of the submission's functions.

    A ray that stops short of everything counts as well: by the submission's own sky.
    """
    args = {"r": batch.args["r"], "it": bench.core.zeros("intersection", batch.count)}
    met = bench.again(Batch("nearest_hit", args, {}))
    hit = met.got("result").astype(bool)
    seen = bench.again(Batch("hit_color", {"r": met.got("r"), "it": met.got("it")}, {}))
    away = batch.args["r"].copy()
    away["orig"], away["tmax"] = (0, 1e6, 0), 1
    sky = bench.again(Batch("trace_ray", {"r": away}, {})).got("result")
    return np.where(hit[:, None], seen.got("result"), sky)
