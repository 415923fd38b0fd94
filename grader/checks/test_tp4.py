"""TP4 - shadows and mirrors."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from grader.checking.comparison import unit
from grader.checking.expected_data import Array, Batch
from grader.checking.ray_origins import expect_fresh, expect_origin
from grader.checking.student import Answers, Bench, Student
from grader.checks import solids
from grader.checks.common import met_alone
from grader.checks.shadows import expect_free

# ---- TP4.1: in_shadow ---------------------------------------------------------------------------


@pytest.mark.check("tp4.in_shadow.kinds")
def test_in_shadow_kinds(student: Student) -> None:
    """Objects of all kinds bar the way, whatever they are made of."""
    expect_free(student)
    judged = 0
    for batch in student.batches("in_shadow.kinds"):
        with student.bench() as bench:
            trial = bench.trial(batch)
            # A cylinder may not be written yet, or be wrong.
            sound = met_alone(bench, batch, _towards_the_light(bench, batch)).sound
        trial.expect("result", where=sound)
        judged += np.count_nonzero(sound & ~trial.refused)
    if not judged:  # no object is met yet
        trial.expect("result")


def _towards_the_light(bench: Bench, batch: Batch) -> Array:
    """Return the rays from the points to the light."""
    start, light = batch.args["it"]["position"], batch.args["from"]["position"]
    rays = bench.core.zeros("ray", batch.count)
    rays["orig"], rays["dir"], rays["tmin"], rays["tmax"] = start, light - start, 1e-3, 1
    return rays


# ---- TP4.2: reflected_ray -----------------------------------------------------------------------

# Cosine between the new direction and the one that arrives, or the normal: above, it is a copy.
COPY = 0.999


def bounced(student: Student, *suites: str) -> Iterator[Answers]:
    """Yield the answers to suites, if the directions are no copies of what is given."""
    for suite in suites:
        for trial in student.trials(suite):
            way = unit(trial.got("out.dir"))
            given = (unit(trial.batch.args["in"]["dir"]), trial.batch.args["it"]["normal"])
            same = [np.abs(np.einsum("ij,ij->i", way, each)) > COPY for each in given]
            still = np.abs(way - way[0]).max(axis=1) < 1 - COPY
            if any(each.mean() > 0.5 for each in (*same, still)):
                trial.expect("out.dir", by=unit)
            yield trial


@pytest.mark.check("tp4.reflected_ray.direction")
def test_reflected_ray_direction(student: Student) -> None:
    """The direction is reflected about the normal."""
    for trial in student.trials("reflected_ray.unit"):
        trial.expect("out.dir", by=unit)


@pytest.mark.check("tp4.reflected_ray.unit")
def test_reflected_ray_unit(student: Student) -> None:
    """The new direction is unit, even when the ray that arrives has none such."""
    for trial in bounced(student, "reflected_ray.scaled"):
        own = unit(trial.got("out.dir")).astype(np.float32)
        solids.judged_by(trial, "out.dir", own).expect("out.dir")


@pytest.mark.check("tp4.reflected_ray.origin")
def test_reflected_ray_origin(student: Student) -> None:
    """The new ray starts at the point hit, a little off the surface, on the side it goes to."""
    for trial in bounced(student, "reflected_ray.unit", "reflected_ray.inside"):
        expect_origin(trial, np.ones(trial.batch.count, bool))


@pytest.mark.check("tp4.reflected_ray.depth")
def test_reflected_ray_depth(student: Student) -> None:
    """The depth is one more than that of the ray that arrives."""
    for trial in bounced(student, "reflected_ray.unit"):
        trial.expect("out.depth")


@pytest.mark.check("tp4.reflected_ray.fresh")
def test_reflected_ray_fresh(student: Student) -> None:
    """The new ray has a range of its own, and goes on with the seed."""
    for trial in bounced(student, "reflected_ray.unit"):
        expect_fresh(trial, np.ones(trial.batch.count, bool))
        trial.expect("out.seed")
