"""TP5 - Fresnel and samples."""

from __future__ import annotations

import numpy as np
import pytest

from grader.checking.comparison import far
from grader.checking.describe import pair, setting
from grader.checking.expected_data import SIZE, Batch
from grader.checking.looks import Look
from grader.checking.records import Evidence
from grader.checking.reproducer import of_command
from grader.checking.student import Bench, Student, Wrong
from grader.checks import fresnel
from grader.checks.common import check_results

# ---- TP5.2: Fresnel in shade and mirror_color ---------------------------------------------------


@pytest.mark.check("tp5.fresnel_use.lobe")
def test_fresnel_use_lobe(student: Student) -> None:
    """In shade, Fresnel's coefficient stands in the place of ks."""
    try:
        check_results(student, "fresnel_use.lobe")
    except Wrong:
        if not fresnel.is_used_in_shade(student):
            raise


@pytest.mark.check("tp5.fresnel_use.mirror")
def test_fresnel_use_mirror(student: Student) -> None:
    """In mirror_color, Fresnel's coefficient stands in the place of ks."""
    try:
        check_results(student, "fresnel_use.mirror")
    except Wrong:
        if not fresnel.is_used_in_mirror(student):
            raise


@pytest.mark.check("tp5.fresnel_use.unit")
def test_fresnel_use_unit(student: Student) -> None:
    """The direction of the ray that arrives may have any length: the coefficient is the same."""
    fresnel.expect_any_length(student)


# ---- TP5.3: pixel_color -------------------------------------------------------------------------

# Shares of the difference between two colours: what is seen of a sample, and of nothing at all.
SEEN, SAME = 0.02, 1e-3
FULL = 0.99  # of a channel: less where a part of the samples is dim


@pytest.mark.check("tp5.pixel_color.spread")
def test_pixel_color_spread(student: Student) -> None:
    """There is a sample in every square of the pixel."""
    for trial in student.trials("pixel_color.spread"):
        corner, covered, sky = trial.got("result").astype(np.float64)
        contrast = np.abs(sky - covered).max()
        share = np.abs(corner - covered).max() / max(contrast, SAME)
        if not (contrast > SEEN and SEEN < share < 1 - SEEN):
            trial.expect("result")
            raise Wrong("failure.flat_picture")


@pytest.mark.check("tp5.pixel_color.clamped")
def test_pixel_color_clamped(student: Student) -> None:
    """Each sample is clamped to [0, 1] before the mean."""
    for trial in student.trials("pixel_color.clamped"):
        got = trial.got("result")
        edge, *beside = got[:, 0].astype(np.float64)
        right = max(*beside, edge) <= 1 + SAME and edge < FULL and np.ptp(beside) > SEEN
        trial.complain(
            np.array([not right, False, False]),
            "failure.result",
            got=got,
            expected=trial.batch.answers[0].result,
        )


@pytest.mark.check("tp5.pixel_color.uniform")
def test_pixel_color_uniform(student: Student) -> None:
    """Where all the samples see the same, the mean is that colour."""
    expect_views(student)
    check_results(student, "pixel_color.uniform")


def expect_views(student: Student) -> None:
    """Raise Wrong unless pixels that see different things have different colours."""
    for trial in student.trials("pixel_color.spread"):
        if np.ptp(trial.got("result"), axis=0).max() < SEEN:
            trial.expect("result")


@pytest.mark.check("tp5.pixel_color.used")
def test_pixel_color_used(student: Student) -> None:
    """With several samples, raytrace draws the picture with pixel_color."""
    expect_views(student)
    batches = student.batches("pixel_color.mean")
    batch = next(each for each in batches if each.globals["options"]["samples"] == 2)
    with student.bench() as bench:
        expected = bench.trial(batch).got("result")
        bench.call("raytrace", f"raytrace(){setting(batch)}")
        picture = bench.session.get("output_image")
    i, j = batch.args["i"], batch.args["j"]
    got = picture[j * SIZE[0] + i]
    for k in np.flatnonzero(far(got, expected, batch.tolerance)):
        wrong = Wrong("failure.picture", i=i[k], j=j[k], **pair(got[k], expected[k]))
        look = Look(f"output_image[{j[k]} * WIDTH + {i[k]}]", expected[k])
        raise wrong.showing(Evidence(reproducer=of_command("raytrace", [], batch, look)))


@pytest.mark.check("tp5.pixel_color.seeds")
def test_pixel_color_seeds(student: Student) -> None:
    """Each sample has a seed of its own, so that what is drawn at random is averaged too."""
    expect_views(student)
    (batch,) = student.batches("pixel_color.seeds")
    with student.bench() as bench:
        trial = bench.trial(batch)
        if not draws_at_random(bench, batch):
            return  # nothing that is drawn can be seen without glass
    got = trial.got("result")[:, 2].astype(np.float64)
    extreme = (np.abs(got - got.min()) < SEEN) | (np.abs(got - got.max()) < SEEN)
    alike = np.full(batch.count, bool(extreme.all()))
    trial.complain(alike, "failure.one_seed", got=trial.got("result"))


def draws_at_random(bench: Bench, batch: Batch) -> bool:
    """Say whether the colour along one ray changes with its seed."""
    x, y = (batch.args[name].astype(np.float32) + np.float32(0.5) for name in "ij")
    rays = Batch("camera_ray", {"r": bench.core.zeros("ray", batch.count), "x": x, "y": y}, {})
    seen = bench.again(rays).got("r")
    one = np.repeat(seen[:1], batch.count)
    one["seed"] = np.arange(2, 2 + batch.count)
    colors = bench.again(Batch("trace_ray", {"r": one}, {})).got("result")
    return bool(np.ptp(colors, axis=0).max() > SEEN)
