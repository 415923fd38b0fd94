"""TP5 - Fresnel and samples."""

from __future__ import annotations

import numpy as np
import pytest

from grader.checking.comparison import far
from grader.checking.describe import pair, setting
from grader.checking.expected_data import SIZE
from grader.checking.records import Evidence
from grader.checking.reproducer import Look, of_command
from grader.checking.student import Student, Wrong
from grader.checks import fresnel
from grader.checks.common import check_results

# ---- TP5.1: reflectance, fresnel_schlick --------------------------------------------------------


@pytest.mark.check("tp5.reflectance.any")
def test_reflectance_any(student: Student) -> None:
    """Two indices give the reflectance at normal incidence."""
    check_results(student, "reflectance.any")


@pytest.mark.check("tp5.fresnel_schlick.angle")
def test_fresnel_schlick_angle(student: Student) -> None:
    """Between the two ends, each channel follows the fifth power."""
    check_results(student, "fresnel_schlick.angle")


@pytest.mark.check("tp5.fresnel_schlick.normal")
def test_fresnel_schlick_normal(student: Student) -> None:
    """Seen from above, the coefficient is kr."""
    check_results(student, "fresnel_schlick.normal")


@pytest.mark.check("tp5.fresnel_schlick.grazing")
def test_fresnel_schlick_grazing(student: Student) -> None:
    """Seen along the surface, everything is reflected."""
    check_results(student, "fresnel_schlick.grazing")


@pytest.mark.check("tp5.fresnel_schlick.negative")
def test_fresnel_schlick_negative(student: Student) -> None:
    """A negative n.v counts as 0."""
    check_results(student, "fresnel_schlick.negative")


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


# ---- TP5.3: pixel_color -------------------------------------------------------------------------


@pytest.mark.check("tp5.pixel_color.mean")
def test_pixel_color_mean(student: Student) -> None:
    """On an edge, each colour counts for the share of the samples that see it."""
    check_results(student, "pixel_color.mean")


@pytest.mark.check("tp5.pixel_color.clamped")
def test_pixel_color_clamped(student: Student) -> None:
    """Each sample is clamped to [0, 1] before the mean."""
    check_results(student, "pixel_color.clamped")


@pytest.mark.check("tp5.pixel_color.uniform")
def test_pixel_color_uniform(student: Student) -> None:
    """Where all the samples see the same, the mean is that colour."""
    check_results(student, "pixel_color.uniform")


@pytest.mark.check("tp5.pixel_color.used")
def test_pixel_color_used(student: Student) -> None:
    """With several samples, raytrace draws the picture with pixel_color."""
    batches = student.batches("pixel_color.mean")
    batch = next(each for each in batches if each.globals["options"]["samples"] == 2)
    with student.bench() as bench:
        own = bench.trial(batch).got("result")
        bench.call("raytrace", f"raytrace(){setting(batch)}")
        picture = bench.session.get("output_image")
    i, j = batch.args["i"], batch.args["j"]
    got = picture[j * SIZE[0] + i]
    accepted = [each.result for each in batch.answers if each.result is not None]
    if all(far(got, each, batch.tolerance).any() for each in accepted):
        k = int(np.flatnonzero(far(got, accepted[0], batch.tolerance))[0])
        values = {"i": i[k], "j": j[k], **pair(got[k], accepted[0][k])}
        is_used = not far(got, own, batch.tolerance).any()
        wrong = Wrong("failure.picture", part="pixel_color" if is_used else "", **values)
        look = Look(f"output_image[{j[k]} * WIDTH + {i[k]}]", accepted[0][k])
        raise wrong.showing(Evidence(reproducer=of_command("raytrace", [], batch, look)))
