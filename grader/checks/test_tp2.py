"""TP2 - rays and objects: the camera, the picture, planes and spheres."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from grader.checking.comparison import unit
from grader.checking.expected_data import SIZE
from grader.checking.pictures import whole
from grader.checking.student import Answers, Student, Wrong
from grader.checks import raytrace, solids

# A ray of the camera sees at least that far, in whatever units of its direction.
FAR = 100.0
# A start of the range that only keeps a ray off its own origin.
NEAR = 5e-3


# ---- TP2.1: camera_ray --------------------------------------------------------------------------

# Half a pixel too far is another check's question.
ABOUT = 1.5 / SIZE[0]
# Mean cosine between the rays and the right ones; it is more where left and right are exchanged.
TOWARDS = 0.2


def check_directions(student: Student, suite: str, tolerance: float = 0.0) -> None:
    """Compare directions, unit or not; by default as exactly as the suite says."""
    for trial in student.trials(suite):
        batch = replace(trial.batch, tolerance=tolerance or trial.batch.tolerance)
        replace(trial, batch=batch).expect("r.dir", by=unit)


def looking(student: Student, suite: str = "camera_ray.anywhere") -> Iterator[Answers]:
    """Yield the answers to a suite, if the rays are spread over about what the camera sees."""
    for trial in student.trials(suite):
        got, right = unit(trial.got("r.dir")), unit(trial.batch.answers[0].out["r"]["dir"])
        spread = np.ptp(got, axis=0).max() > ABOUT
        if not (spread and np.einsum("ij,ij->i", got, right).mean() > TOWARDS):
            trial.expect("r.dir", by=unit)
        yield trial


@pytest.mark.check("tp2.camera_ray.horizontal")
def test_camera_ray_horizontal(student: Student) -> None:
    """From left to right, the ray turns along xdir."""
    check_directions(student, "camera_ray.horizontal", ABOUT)


@pytest.mark.check("tp2.camera_ray.vertical")
def test_camera_ray_vertical(student: Student) -> None:
    """From bottom to top, the ray turns along ydir, by the picture's height."""
    check_directions(student, "camera_ray.vertical", ABOUT)


@pytest.mark.check("tp2.camera_ray.anywhere")
def test_camera_ray_anywhere(student: Student) -> None:
    """Everywhere in the picture, and for every camera, the direction is right."""
    check_directions(student, "camera_ray.anywhere", ABOUT)


@pytest.mark.check("tp2.camera_ray.exact")
def test_camera_ray_exact(student: Student) -> None:
    """The position is counted exactly: half a pixel beside it is another ray."""
    check_directions(student, "camera_ray.anywhere")


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
        if np.ptp(drawn.picture.reshape(-1, 3), axis=0).max() < raytrace.FLAT:
            raise Wrong("failure.flat_picture")

    raytrace.check(student, look)


# ---- TP2.3: intersect_plane, TP2.4: intersect_sphere ------------------------------------------


@pytest.mark.check("tp2.intersect_plane.meets")
def test_intersect_plane_meets(student: Student) -> None:
    """Which rays meet the plane."""
    solids.check_meets(student, "intersect_plane.meets")


@pytest.mark.check("tp2.intersect_plane.distance")
def test_intersect_plane_distance(student: Student) -> None:
    """On a hit, tmax becomes the t of the plane."""
    solids.check_distance(student, "intersect_plane.front")


@pytest.mark.check("tp2.intersect_plane.position")
def test_intersect_plane_position(student: Student) -> None:
    """On a hit, the position is the point of the ray at t."""
    solids.check_position(student, "intersect_plane.front")


@pytest.mark.check("tp2.intersect_plane.normal")
def test_intersect_plane_normal(student: Student) -> None:
    """The normal is the plane's, as it is stored."""
    solids.check_normal(student, "intersect_plane.front")


@pytest.mark.check("tp2.intersect_plane.material")
def test_intersect_plane_material(student: Student) -> None:
    """The plane's material is copied, all of it."""
    solids.check_material(student, "intersect_plane.front")


@pytest.mark.check("tp2.intersect_plane.scaled")
def test_intersect_plane_scaled(student: Student) -> None:
    """With a direction that is not unit, t counts in units of the direction."""
    solids.check_scaled(student, "intersect_plane.scaled")


@pytest.mark.check("tp2.intersect_plane.range")
def test_intersect_plane_range(student: Student) -> None:
    """Only a t between tmin and tmax counts."""
    solids.check_range(student, "intersect_plane.range")


@pytest.mark.check("tp2.intersect_plane.behind")
def test_intersect_plane_behind(student: Student) -> None:
    """A plane behind the ray is missed."""
    solids.check_missed(student, "intersect_plane", "behind")


@pytest.mark.check("tp2.intersect_plane.grazing")
def test_intersect_plane_grazing(student: Student) -> None:
    """A ray that runs nearly along the plane meets it all the same."""
    solids.check_meets(student, "intersect_plane.grazing")


@pytest.mark.check("tp2.intersect_plane.parallel")
def test_intersect_plane_parallel(student: Student) -> None:
    """A ray parallel to the plane misses it."""
    solids.check_missed(student, "intersect_plane", "parallel")


@pytest.mark.check("tp2.intersect_plane.miss")
def test_intersect_plane_miss(student: Student) -> None:
    """On a miss, nothing changes."""
    solids.check_refusals(student, "intersect_plane", "behind", "parallel", "range")


@pytest.mark.check("tp2.intersect_plane.only")
def test_intersect_plane_only(student: Student) -> None:
    """Of the ray, a hit changes tmax and nothing else."""
    solids.check_only(student, "intersect_plane.front", "intersect_plane.scaled")


def check_sphere_normal(student: Student, suite: str) -> None:
    """Compare the normals with those of the right points, or of the submission's own."""
    for trial in student.trials(suite):
        solids.expect_computed(trial)
        found, centre = solids.met(trial), trial.batch.args["obj"]["center"]
        own = unit(trial.got("it.position") - centre).astype(np.float32)
        with contextlib.suppress(Wrong):
            solids.judged_by(trial.aside(), "it.normal", own).expect("it.normal", where=found)
            continue
        trial.expect("it.normal", where=found)


@pytest.mark.check("tp2.intersect_sphere.meets")
def test_intersect_sphere_meets(student: Student) -> None:
    """Which rays meet the sphere, and which do not."""
    solids.check_meets(student, "intersect_sphere.meets")


@pytest.mark.check("tp2.intersect_sphere.distance")
def test_intersect_sphere_distance(student: Student) -> None:
    """On a hit from outside, tmax becomes the t of the nearer point."""
    solids.check_distance(student, "intersect_sphere.front")


@pytest.mark.check("tp2.intersect_sphere.position")
def test_intersect_sphere_position(student: Student) -> None:
    """On a hit, the position is the point of the ray at t."""
    solids.check_position(student, "intersect_sphere.front")


@pytest.mark.check("tp2.intersect_sphere.normal")
def test_intersect_sphere_normal(student: Student) -> None:
    """The normal is unit and points outwards."""
    check_sphere_normal(student, "intersect_sphere.front")


@pytest.mark.check("tp2.intersect_sphere.material")
def test_intersect_sphere_material(student: Student) -> None:
    """The sphere's material is copied, all of it."""
    solids.check_material(student, "intersect_sphere.front")


@pytest.mark.check("tp2.intersect_sphere.from_inside")
def test_intersect_sphere_from_inside(student: Student) -> None:
    """From inside, the second point counts, and the normal still points outwards."""
    solids.check_inside(student, "intersect_sphere.inside")


@pytest.mark.check("tp2.intersect_sphere.scaled")
def test_intersect_sphere_scaled(student: Student) -> None:
    """With a direction that is not unit, t counts in units of the direction."""
    solids.check_scaled(student, "intersect_sphere.scaled")


@pytest.mark.check("tp2.intersect_sphere.range")
def test_intersect_sphere_range(student: Student) -> None:
    """Of the two points, the first between tmin and tmax counts."""
    solids.check_range(student, "intersect_sphere.range")


@pytest.mark.check("tp2.intersect_sphere.behind")
def test_intersect_sphere_behind(student: Student) -> None:
    """A sphere behind the ray is missed."""
    solids.check_missed(student, "intersect_sphere", "behind")


@pytest.mark.check("tp2.intersect_sphere.miss")
def test_intersect_sphere_miss(student: Student) -> None:
    """When the ray passes by, nothing changes."""
    solids.check_refusals(student, "intersect_sphere", "meets", "behind", "range")


@pytest.mark.check("tp2.intersect_sphere.only")
def test_intersect_sphere_only(student: Student) -> None:
    """Of the ray, a hit changes tmax and nothing else."""
    solids.check_only(student, "intersect_sphere.front", "intersect_sphere.scaled")
