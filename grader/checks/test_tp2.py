"""TP2 - rays and objects: the camera, the picture, planes and spheres."""

from __future__ import annotations

import numpy as np
import pytest

from grader.checking.expected_data import SIZE
from grader.checking.pictures import whole
from grader.checking.student import Student, Wrong
from grader.checks import raytrace
from grader.checks.camera import check_directions, looking

# A ray of the camera sees at least that far, in whatever units of its direction.
FAR = 100.0
# A start of the range that only keeps a ray off its own origin.
NEAR = 5e-3


# ---- TP2.1: camera_ray --------------------------------------------------------------------------


@pytest.mark.check("tp2.camera_ray.middle")
def test_camera_ray_middle(student: Student) -> None:
    """The ray through the middle of the picture goes where the camera looks."""
    list(looking(student))
    check_directions(student, "camera_ray.middle")


@pytest.mark.check("tp2.camera_ray.origin")
def test_camera_ray_origin(student: Student) -> None:
    """The ray starts at the camera's position."""
    for trial in looking(student):
        trial.expect("r.orig")


@pytest.mark.check("tp2.camera_ray.fresh")
def test_camera_ray_fresh(student: Student) -> None:
    """The ray is new: tmin 0, a large tmax, depth 0, a seed."""
    for trial in looking(student):
        trial.expect("r.depth")
        tmin, tmax, seed = (trial.got(f"r.{name}") for name in ("tmin", "tmax", "seed"))
        for name, got, right in (
            ("tmin", tmin, (tmin >= 0) & (tmin <= NEAR)),
            ("tmax", tmax, tmax >= FAR),
            ("seed", seed, seed != trial.batch.args["r"]["seed"]),
        ):
            values = {"got": got, "expected": trial.batch.answers[0].out["r"][name]}
            trial.complain(~right, "failure.output", what=f"r->{name}", **values)


# ---- TP2.2: raytrace ----------------------------------------------------------------------------


@pytest.mark.check("tp2.raytrace.colors")
def test_raytrace_colors(student: Student) -> None:
    """Each pixel has the colour that trace_ray finds along its ray."""

    def look(drawn: raytrace.Drawn) -> None:
        try:
            drawn.compare(drawn.corner)
        except Wrong:
            raytrace.note(student, drawn, drawn.centre)
            drawn.compare(drawn.centre)

    raytrace.check(student, look)


@pytest.mark.check("tp2.raytrace.centre")
def test_raytrace_centre(student: Student) -> None:
    """The ray of a pixel goes through its centre."""

    def look(drawn: raytrace.Drawn) -> None:
        # Upside down, or left for right, is another check's question.
        flat = np.ptp(drawn.centre.reshape(-1, 3), axis=0).max() < raytrace.FLAT
        if flat or not whole.turned(drawn.picture, drawn.centre, drawn.batch.tolerance):
            raytrace.note(student, drawn, drawn.centre)
            drawn.compare(drawn.centre)

    raytrace.check(student, look)


@pytest.mark.check("tp2.raytrace.every_pixel")
def test_raytrace_every_pixel(student: Student) -> None:
    """Every pixel of the picture is written."""

    def look(drawn: raytrace.Drawn) -> None:
        unwritten = (drawn.picture == raytrace.UNWRITTEN).all(axis=2).ravel()
        left = np.flatnonzero(unwritten)
        if len(left):
            student.observations.note_mask("left", unwritten)
            j, i = divmod(int(left[0]), SIZE[0])
            raise Wrong("failure.unwritten", i=i, j=j, width=SIZE[0], height=SIZE[1])
        if raytrace.is_painted(drawn.picture):
            raise Wrong("failure.flat_picture")

    raytrace.check(student, look)
