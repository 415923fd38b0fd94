"""TP2, bonus: cylinders and cones, closed by discs."""

from __future__ import annotations

import pytest

from grader.checking.student import Student
from grader.checks import solids

# ---- TP2.B1: intersect_cylinder -----------------------------------------------------------------


@pytest.mark.check("tp2.intersect_cylinder.meets")
def test_intersect_cylinder_meets(student: Student) -> None:
    """Which rays meet the side of the cylinder, and which meet nothing."""
    solids.check_meets(student, "intersect_cylinder.meets")


@pytest.mark.check("tp2.intersect_cylinder.distance")
def test_intersect_cylinder_distance(student: Student) -> None:
    """On a hit from outside, tmax and the position are those of the nearest point."""
    solids.check_distance(student, "intersect_cylinder.front")
    solids.check_position(student, "intersect_cylinder.front")


@pytest.mark.check("tp2.intersect_cylinder.normal")
def test_intersect_cylinder_normal(student: Student) -> None:
    """The normal of the side is unit and points outwards."""
    solids.check_normal(student, "intersect_cylinder.front")


@pytest.mark.check("tp2.intersect_cylinder.caps")
def test_intersect_cylinder_caps(student: Student) -> None:
    """A disc closes each end."""
    solids.check_caps(student, "intersect_cylinder.caps")


@pytest.mark.check("tp2.intersect_cylinder.from_inside")
def test_intersect_cylinder_from_inside(student: Student) -> None:
    """From inside, the point where the ray leaves counts."""
    solids.check_inside(student, "intersect_cylinder.inside")


@pytest.mark.check("tp2.intersect_cylinder.range")
def test_intersect_cylinder_range(student: Student) -> None:
    """Of the points met, the first between tmin and tmax counts, in units of the direction."""
    solids.check_range(student, "intersect_cylinder.range")
    solids.check_scaled(student, "intersect_cylinder.scaled")


@pytest.mark.check("tp2.intersect_cylinder.material")
def test_intersect_cylinder_material(student: Student) -> None:
    """The cylinder's material is copied, all of it."""
    solids.check_material(student, "intersect_cylinder.front")


@pytest.mark.check("tp2.intersect_cylinder.miss")
def test_intersect_cylinder_miss(student: Student) -> None:
    """When the ray misses, nothing changes."""
    solids.check_refusals(student, "intersect_cylinder", "behind", "meets", "range")


@pytest.mark.check("tp2.intersect_cylinder.only")
def test_intersect_cylinder_only(student: Student) -> None:
    """Of the ray, a hit changes tmax and nothing else."""
    solids.check_only(student, "intersect_cylinder.front", "intersect_cylinder.scaled")


# ---- TP2.B2: intersect_cone ---------------------------------------------------------------------


@pytest.mark.check("tp2.intersect_cone.meets")
def test_intersect_cone_meets(student: Student) -> None:
    """Which rays meet the side of the cone, and which meet nothing."""
    solids.check_meets(student, "intersect_cone.meets")


@pytest.mark.check("tp2.intersect_cone.distance")
def test_intersect_cone_distance(student: Student) -> None:
    """On a hit from outside, tmax and the position are those of the nearest point."""
    solids.check_distance(student, "intersect_cone.front")
    solids.check_position(student, "intersect_cone.front")


@pytest.mark.check("tp2.intersect_cone.normal")
def test_intersect_cone_normal(student: Student) -> None:
    """The normal of the side is unit and points outwards."""
    solids.check_normal(student, "intersect_cone.front")


@pytest.mark.check("tp2.intersect_cone.caps")
def test_intersect_cone_caps(student: Student) -> None:
    """A disc closes the base."""
    solids.check_caps(student, "intersect_cone.caps")


@pytest.mark.check("tp2.intersect_cone.from_inside")
def test_intersect_cone_from_inside(student: Student) -> None:
    """From inside, the point where the ray leaves counts."""
    solids.check_inside(student, "intersect_cone.inside")


@pytest.mark.check("tp2.intersect_cone.range")
def test_intersect_cone_range(student: Student) -> None:
    """Of the points met, the first between tmin and tmax counts, in units of the direction."""
    solids.check_range(student, "intersect_cone.range")
    solids.check_scaled(student, "intersect_cone.scaled")


@pytest.mark.check("tp2.intersect_cone.material")
def test_intersect_cone_material(student: Student) -> None:
    """The cone's material is copied, all of it."""
    solids.check_material(student, "intersect_cone.front")


@pytest.mark.check("tp2.intersect_cone.miss")
def test_intersect_cone_miss(student: Student) -> None:
    """When the ray misses, nothing changes."""
    solids.check_refusals(student, "intersect_cone", "behind", "meets", "range")


@pytest.mark.check("tp2.intersect_cone.only")
def test_intersect_cone_only(student: Student) -> None:
    """Of the ray, a hit changes tmax and nothing else."""
    solids.check_only(student, "intersect_cone.front", "intersect_cone.scaled")
