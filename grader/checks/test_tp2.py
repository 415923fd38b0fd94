"""TP2 - rays and objects: the camera, intersections, the colour along a ray."""

from __future__ import annotations

import numpy as np
import pytest

from grader.checking.comparison import unit
from grader.checking.expected_data import SIZE
from grader.checking.student import Student, Wrong
from grader.checks import raytrace
from grader.checks.common import check_answers, check_material, check_refusals, check_stages

# A ray of the camera sees at least that far, in whatever units of its direction.
FAR = 100.0
# A start of the range that only keeps a ray off its own origin.
NEAR = 5e-3


# ---- TP2.1: camera_ray --------------------------------------------------------------------------


def check_directions(student: Student, suite: str) -> None:
    """Compare directions, unit or not."""
    for trial in student.trials(suite):
        trial.expect("r.dir", by=unit)


@pytest.mark.check("tp2.camera_ray.horizontal")
def test_camera_ray_horizontal(student: Student) -> None:
    """From left to right, the ray turns along xdir."""
    check_directions(student, "camera_ray.horizontal")


@pytest.mark.check("tp2.camera_ray.vertical")
def test_camera_ray_vertical(student: Student) -> None:
    """From bottom to top, the ray turns along ydir, by the picture's height."""
    check_directions(student, "camera_ray.vertical")


@pytest.mark.check("tp2.camera_ray.anywhere")
def test_camera_ray_anywhere(student: Student) -> None:
    """Everywhere in the picture, and for every camera, the direction is right."""
    check_directions(student, "camera_ray.anywhere")


@pytest.mark.check("tp2.camera_ray.middle")
def test_camera_ray_middle(student: Student) -> None:
    """The ray through the middle of the picture goes where the camera looks."""
    check_directions(student, "camera_ray.middle")


@pytest.mark.check("tp2.camera_ray.origin")
def test_camera_ray_origin(student: Student) -> None:
    """The ray starts at the camera's position."""
    for trial in student.trials("camera_ray.anywhere"):
        trial.expect("r.orig")


@pytest.mark.check("tp2.camera_ray.fresh")
def test_camera_ray_fresh(student: Student) -> None:
    """The ray is new: tmin 0, a large tmax, depth 0."""
    for trial in student.trials("camera_ray.anywhere"):
        trial.expect("r.depth")
        tmin, tmax = trial.got("r.tmin"), trial.got("r.tmax")
        for name, got, right in (
            ("tmin", tmin, (tmin >= 0) & (tmin <= NEAR)),
            ("tmax", tmax, tmax >= FAR),
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

    raytrace.check(student, look)


# ---- TP2.3: intersect_plane, TP2.4: intersect_sphere ------------------------------------------


@pytest.mark.check("tp2.intersect_plane.meets")
def test_intersect_plane_meets(student: Student) -> None:
    """Which rays meet the plane, and which do not."""
    check_answers(student, "intersect_plane.meets", "result")


@pytest.mark.check("tp2.intersect_plane.distance")
def test_intersect_plane_distance(student: Student) -> None:
    """On a hit, tmax becomes the t of the plane."""
    check_answers(student, "intersect_plane.front", "r.tmax")


@pytest.mark.check("tp2.intersect_plane.position")
def test_intersect_plane_position(student: Student) -> None:
    """On a hit, the position is the point of the ray at t."""
    check_answers(student, "intersect_plane.front", "it.position")


@pytest.mark.check("tp2.intersect_plane.normal")
def test_intersect_plane_normal(student: Student) -> None:
    """The normal is the plane's, as it is stored."""
    check_answers(student, "intersect_plane.front", "it.normal")


@pytest.mark.check("tp2.intersect_plane.material")
def test_intersect_plane_material(student: Student) -> None:
    """The plane's material is copied."""
    check_material(student, "intersect_plane.front")


@pytest.mark.check("tp2.intersect_plane.scaled")
def test_intersect_plane_scaled(student: Student) -> None:
    """With a direction that is not unit, t counts in units of the direction."""
    check_answers(student, "intersect_plane.scaled", "result", "r.tmax", "it.position")


@pytest.mark.check("tp2.intersect_plane.range")
def test_intersect_plane_range(student: Student) -> None:
    """Only a t between tmin and tmax counts."""
    check_answers(student, "intersect_plane.range", "result", "r.tmax")


@pytest.mark.check("tp2.intersect_plane.behind")
def test_intersect_plane_behind(student: Student) -> None:
    """A plane behind the ray is missed, and nothing changes."""
    check_refusals(student, "intersect_plane.behind")


@pytest.mark.check("tp2.intersect_plane.parallel")
def test_intersect_plane_parallel(student: Student) -> None:
    """A ray parallel to the plane misses it."""
    check_refusals(student, "intersect_plane.parallel")


@pytest.mark.check("tp2.intersect_sphere.meets")
def test_intersect_sphere_meets(student: Student) -> None:
    """Which rays meet the sphere, and which do not."""
    check_answers(student, "intersect_sphere.meets", "result")


@pytest.mark.check("tp2.intersect_sphere.distance")
def test_intersect_sphere_distance(student: Student) -> None:
    """On a hit from outside, tmax becomes the t of the nearer point."""
    check_answers(student, "intersect_sphere.front", "r.tmax")


@pytest.mark.check("tp2.intersect_sphere.position")
def test_intersect_sphere_position(student: Student) -> None:
    """On a hit, the position is the point of the ray at t."""
    check_answers(student, "intersect_sphere.front", "it.position")


@pytest.mark.check("tp2.intersect_sphere.normal")
def test_intersect_sphere_normal(student: Student) -> None:
    """The normal is unit and points outwards."""
    check_answers(student, "intersect_sphere.front", "it.normal")


@pytest.mark.check("tp2.intersect_sphere.material")
def test_intersect_sphere_material(student: Student) -> None:
    """The sphere's material is copied."""
    check_material(student, "intersect_sphere.front")


@pytest.mark.check("tp2.intersect_sphere.from_inside")
def test_intersect_sphere_from_inside(student: Student) -> None:
    """From inside, the second point counts, and the normal still points outwards."""
    check_answers(student, "intersect_sphere.inside", "result", "r.tmax", "it.normal")


@pytest.mark.check("tp2.intersect_sphere.scaled")
def test_intersect_sphere_scaled(student: Student) -> None:
    """With a direction that is not unit, t counts in units of the direction."""
    check_answers(student, "intersect_sphere.scaled", "result", "r.tmax", "it.position")


@pytest.mark.check("tp2.intersect_sphere.range")
def test_intersect_sphere_range(student: Student) -> None:
    """Of the two points, the first between tmin and tmax counts."""
    check_answers(student, "intersect_sphere.range", "result", "r.tmax")


@pytest.mark.check("tp2.intersect_sphere.behind")
def test_intersect_sphere_behind(student: Student) -> None:
    """A sphere behind the ray is missed, and nothing changes."""
    check_refusals(student, "intersect_sphere.behind")


@pytest.mark.check("tp2.intersect_sphere.miss")
def test_intersect_sphere_miss(student: Student) -> None:
    """When the ray passes by, nothing changes."""
    check_refusals(student, "intersect_sphere.meets", "intersect_sphere.range")


# ---- TP2.5: intersect_scene, TP2.6: trace_ray ---------------------------------------------------


@pytest.mark.check("tp2.intersect_scene.meets")
def test_intersect_scene_meets(student: Student) -> None:
    """Which rays meet an object of the scene, whichever it is."""
    check_answers(student, "intersect_scene.meets", "result")


@pytest.mark.check("tp2.intersect_scene.nearest")
def test_intersect_scene_nearest(student: Student) -> None:
    """The nearest object counts, not the first or the last of the list."""
    check_answers(student, "intersect_scene.nearest", "r.tmax", "it.position", "it.mat.kd")


@pytest.mark.check("tp2.intersect_scene.kinds")
def test_intersect_scene_kinds(student: Student) -> None:
    """Planes and spheres stand in one scene."""
    check_answers(student, "intersect_scene.kinds", "result", "r.tmax", "it.mat.kd")


@pytest.mark.check("tp2.intersect_scene.nothing")
def test_intersect_scene_nothing(student: Student) -> None:
    """When nothing is met, or the scene is empty, nothing changes."""
    check_refusals(student, "intersect_scene.nothing")


@pytest.mark.check("tp2.trace_ray.object")
def test_trace_ray_object(student: Student) -> None:
    """A ray that meets an object has the colour of what is hit."""
    check_stages(student, "trace_ray.object")


@pytest.mark.check("tp2.trace_ray.sky")
def test_trace_ray_sky(student: Student) -> None:
    """A ray that meets nothing has the colour of the sky."""
    check_stages(student, "trace_ray.sky")


@pytest.mark.check("tp2.trace_ray.depth")
def test_trace_ray_depth(student: Student) -> None:
    """A ray that has bounced more than max_depth times is black."""
    check_stages(student, "trace_ray.depth")
