"""TP2, bonus: cylinders and cones, closed by discs."""

from __future__ import annotations

import pytest

from grader.checking.student import Student
from grader.checks.common import check_answers, check_material, check_refusals

# ---- TP2.B1: intersect_cylinder -----------------------------------------------------------------


@pytest.mark.check("tp2.intersect_cylinder.meets")
def test_intersect_cylinder_meets(student: Student) -> None:
    """Which rays meet the cylinder, and which do not."""
    check_answers(student, "intersect_cylinder.meets", "result")


@pytest.mark.check("tp2.intersect_cylinder.distance")
def test_intersect_cylinder_distance(student: Student) -> None:
    """On a hit from outside, tmax and the position are those of the nearest point."""
    check_answers(student, "intersect_cylinder.front", "r.tmax", "it.position")


@pytest.mark.check("tp2.intersect_cylinder.normal")
def test_intersect_cylinder_normal(student: Student) -> None:
    """The normal is unit and points outwards, on the side and on the discs."""
    check_answers(student, "intersect_cylinder.front", "it.normal")


@pytest.mark.check("tp2.intersect_cylinder.caps")
def test_intersect_cylinder_caps(student: Student) -> None:
    """A disc closes each end."""
    check_answers(student, "intersect_cylinder.caps", "result", "r.tmax", "it.normal")


@pytest.mark.check("tp2.intersect_cylinder.from_inside")
def test_intersect_cylinder_from_inside(student: Student) -> None:
    """From inside, the point where the ray leaves counts."""
    check_answers(student, "intersect_cylinder.inside", "result", "r.tmax", "it.normal")


@pytest.mark.check("tp2.intersect_cylinder.range")
def test_intersect_cylinder_range(student: Student) -> None:
    """Of the points met, the first between tmin and tmax counts, in units of the direction."""
    check_answers(student, "intersect_cylinder.range", "result", "r.tmax")
    check_answers(student, "intersect_cylinder.scaled", "result", "r.tmax")


@pytest.mark.check("tp2.intersect_cylinder.material")
def test_intersect_cylinder_material(student: Student) -> None:
    """The cylinder's material is copied."""
    check_material(student, "intersect_cylinder.front")


@pytest.mark.check("tp2.intersect_cylinder.miss")
def test_intersect_cylinder_miss(student: Student) -> None:
    """When the ray misses, nothing changes."""
    check_refusals(student, "intersect_cylinder.behind", "intersect_cylinder.meets")


# ---- TP2.B2: intersect_cone ---------------------------------------------------------------------


@pytest.mark.check("tp2.intersect_cone.meets")
def test_intersect_cone_meets(student: Student) -> None:
    """Which rays meet the cone, and which do not."""
    check_answers(student, "intersect_cone.meets", "result")


@pytest.mark.check("tp2.intersect_cone.distance")
def test_intersect_cone_distance(student: Student) -> None:
    """On a hit from outside, tmax and the position are those of the nearest point."""
    check_answers(student, "intersect_cone.front", "r.tmax", "it.position")


@pytest.mark.check("tp2.intersect_cone.normal")
def test_intersect_cone_normal(student: Student) -> None:
    """The normal is unit and points outwards, on the side and on the disc."""
    check_answers(student, "intersect_cone.front", "it.normal")


@pytest.mark.check("tp2.intersect_cone.caps")
def test_intersect_cone_caps(student: Student) -> None:
    """A disc closes the base."""
    check_answers(student, "intersect_cone.caps", "result", "r.tmax", "it.normal")


@pytest.mark.check("tp2.intersect_cone.from_inside")
def test_intersect_cone_from_inside(student: Student) -> None:
    """From inside, the point where the ray leaves counts."""
    check_answers(student, "intersect_cone.inside", "result", "r.tmax", "it.normal")


@pytest.mark.check("tp2.intersect_cone.range")
def test_intersect_cone_range(student: Student) -> None:
    """Of the points met, the first between tmin and tmax counts, in units of the direction."""
    check_answers(student, "intersect_cone.range", "result", "r.tmax")
    check_answers(student, "intersect_cone.scaled", "result", "r.tmax")


@pytest.mark.check("tp2.intersect_cone.material")
def test_intersect_cone_material(student: Student) -> None:
    """The cone's material is copied."""
    check_material(student, "intersect_cone.front")


@pytest.mark.check("tp2.intersect_cone.miss")
def test_intersect_cone_miss(student: Student) -> None:
    """When the ray misses, nothing changes."""
    check_refusals(student, "intersect_cone.behind", "intersect_cone.meets")
