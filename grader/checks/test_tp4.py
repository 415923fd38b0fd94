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
from grader.checks.common import check_results, check_stages, met_alone

# ---- TP4.1: in_shadow ---------------------------------------------------------------------------

FOUND = 0.5  # of the shadows: that none is seen where there is none counts for who sees as many


def check_bars(student: Student, suite: str) -> None:
    """Compare where there is no shadow; it counts for who sees some."""
    for trial in student.trials("in_shadow.blocked"):
        barred = ~trial.refused
        if barred.any() and trial.got("result")[barred].mean() < FOUND:
            trial.expect("result", where=barred)
    check_results(student, suite)


@pytest.mark.check("tp4.in_shadow.blocked")
def test_in_shadow_blocked(student: Student) -> None:
    """An object between the point and the light bars the way; elsewhere it does not."""
    check_results(student, "in_shadow.blocked")


@pytest.mark.check("tp4.in_shadow.near")
def test_in_shadow_near(student: Student) -> None:
    """An object close by the point bars the way as well."""
    expect_free(student)
    check_results(student, "in_shadow.near")


def expect_free(student: Student) -> None:
    """Raise Wrong where everything is called a shadow."""
    for trial in student.trials("in_shadow.blocked"):
        free = trial.refused
        if free.any() and trial.got("result")[free].mean() > FOUND:
            trial.expect("result", where=free)


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


@pytest.mark.check("tp4.in_shadow.which")
def test_in_shadow_which(student: Student) -> None:
    """The light is the one that is given, not the first of the scene."""
    check_results(student, "in_shadow.which")


@pytest.mark.check("tp4.in_shadow.beyond")
def test_in_shadow_beyond(student: Student) -> None:
    """An object beyond the light bars nothing."""
    check_bars(student, "in_shadow.beyond")


@pytest.mark.check("tp4.in_shadow.behind")
def test_in_shadow_behind(student: Student) -> None:
    """An object behind the point bars nothing."""
    check_bars(student, "in_shadow.behind")


@pytest.mark.check("tp4.in_shadow.own_surface")
def test_in_shadow_own_surface(student: Student) -> None:
    """The surface on which the point lies does not bar its own light."""
    check_bars(student, "in_shadow.own")


@pytest.mark.check("tp4.in_shadow.at_light")
def test_in_shadow_at_light(student: Student) -> None:
    """A light at the point itself is not barred."""
    check_bars(student, "in_shadow.at_light")


@pytest.mark.check("tp4.in_shadow.used")
def test_in_shadow_used(student: Student) -> None:
    """direct_light leaves out the lights that are barred, and those only."""
    check_results(student, "in_shadow.used")


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


# ---- TP4.3: mirror_color ------------------------------------------------------------------------


@pytest.mark.check("tp4.mirror_color.sky")
def test_mirror_color_sky(student: Student) -> None:
    """Under an empty sky: the mirror's coefficient times the sky."""
    check_stages(student, "mirror_color.sky", empty=True)


@pytest.mark.check("tp4.mirror_color.object")
def test_mirror_color_object(student: Student) -> None:
    """The mirror shows the object that the reflected ray meets."""
    check_stages(student, "mirror_color.object")


@pytest.mark.check("tp4.mirror_color.depth")
def test_mirror_color_depth(student: Student) -> None:
    """After max_depth bounces the mirror adds nothing more."""
    check_stages(student, "mirror_color.depth")


@pytest.mark.check("tp4.mirror_color.alone")
def test_mirror_color_alone(student: Student) -> None:
    """The mirror adds its reflection alone: no light of its own, no kd."""
    check_stages(student, "mirror_color.alone")


@pytest.mark.check("tp4.mirror_color.channels")
def test_mirror_color_channels(student: Student) -> None:
    """Each channel has a coefficient of its own."""
    check_stages(student, "mirror_color.channels")


@pytest.mark.check("tp4.mirror_color.bright")
def test_mirror_color_bright(student: Student) -> None:
    """What is seen in the mirror is not limited to 1."""
    check_stages(student, "mirror_color.bright")
