"""The pictures of the scenes, stage by stage of the ray tracer; each is a check of an exercise."""

from __future__ import annotations

import pytest

from grader.checking.pictures.judgement import check_picture
from grader.checking.student import Student

# ---- kd alone: what the rays meet ----------------------------------------------------------------


@pytest.mark.check("tp2.scene.flat_0")
def test_scene_flat_0(student: Student) -> None:
    """Scene 0 in flat colours: every object has its place in the picture."""
    check_picture(student, 0, "flat")


@pytest.mark.check("tp2.scene.flat_1")
def test_scene_flat_1(student: Student) -> None:
    """Scene 1 in flat colours."""
    check_picture(student, 1, "flat")


@pytest.mark.check("tp2.scene.flat_4")
def test_scene_flat_4(student: Student) -> None:
    """Scene 4 in flat colours, where three planes hide one another."""
    check_picture(student, 4, "flat")


@pytest.mark.check("tp2.scene.flat_2")
def test_scene_flat_2(student: Student) -> None:
    """Scene 2 in flat colours: three cylinders through a sphere."""
    check_picture(student, 2, "flat")


@pytest.mark.check("tp2.scene.shadows_2")
def test_scene_shadows_2(student: Student) -> None:
    """Scene 2 with its lights and shadows: the cylinders are round, and bar the light."""
    check_picture(student, 2, "shadows")


@pytest.mark.check("tp2.scene.flat_5")
def test_scene_flat_5(student: Student) -> None:
    """Scene 5 in flat colours: cones that stand, lie and lean."""
    check_picture(student, 5, "flat")


@pytest.mark.check("tp2.scene.shadows_5")
def test_scene_shadows_5(student: Student) -> None:
    """Scene 5 with its lights and shadows: sides and discs face the right way."""
    check_picture(student, 5, "shadows")


# ---- Light ---------------------------------------------------------------------------------------


@pytest.mark.check("tp3.scene.blinn_phong_0")
def test_scene_blinn_phong_0(student: Student) -> None:
    """Scene 0 in the light of one far lamp, without shadows."""
    check_picture(student, 0, "blinn_phong")


@pytest.mark.check("tp3.scene.blinn_phong_4")
def test_scene_blinn_phong_4(student: Student) -> None:
    """Scene 4 in the light of three near lamps, without shadows."""
    check_picture(student, 4, "blinn_phong")


@pytest.mark.check("tp3.scene.checker_6")
def test_scene_checker_6(student: Student) -> None:
    """The chequered floor and ball of scene 6."""
    check_picture(student, 6, "blinn_phong", "floor", "sphere_checkered")


@pytest.mark.check("tp3.scene.texture_6")
def test_scene_texture_6(student: Student) -> None:
    """The globe of scene 6, wrapped in a picture."""
    check_picture(student, 6, "blinn_phong", "globe")


# ---- Shadows and mirrors -------------------------------------------------------------------------


@pytest.mark.check("tp4.scene.shadows_0")
def test_scene_shadows_0(student: Student) -> None:
    """The shadows of scene 0."""
    check_picture(student, 0, "shadows")


@pytest.mark.check("tp4.scene.shadows_4")
def test_scene_shadows_4(student: Student) -> None:
    """The shadows of scene 4, whose lamps stand among the objects."""
    check_picture(student, 4, "shadows")


@pytest.mark.check("tp4.scene.mirror_0")
def test_scene_mirror_0(student: Student) -> None:
    """The reflections of scene 0."""
    check_picture(student, 0, "mirror")


@pytest.mark.check("tp4.scene.mirror_4")
def test_scene_mirror_4(student: Student) -> None:
    """The reflections of scene 4, many times over."""
    check_picture(student, 4, "mirror")


@pytest.mark.check("tp4.scene.octree_3")
def test_scene_octree_3(student: Student) -> None:
    """The thousand spheres of scene 3, found through the octree."""
    check_picture(student, 3, "shadows")


# ---- Fresnel, samples, glass ---------------------------------------------------------------------


@pytest.mark.check("tp5.scene.fresnel_0")
def test_scene_fresnel_0(student: Student) -> None:
    """Scene 0 with Fresnel's coefficient."""
    check_picture(student, 0, "fresnel")


@pytest.mark.check("tp5.scene.fresnel_1")
def test_scene_fresnel_1(student: Student) -> None:
    """Scene 1 with Fresnel's coefficient: mirrors that reflect more than they shine."""
    check_picture(student, 1, "fresnel")


@pytest.mark.check("tp5.scene.fresnel_4")
def test_scene_fresnel_4(student: Student) -> None:
    """Scene 4 with Fresnel's coefficient, channel by channel."""
    check_picture(student, 4, "fresnel")


@pytest.mark.check("tp5.scene.smooth_0")
def test_scene_smooth_0(student: Student) -> None:
    """Scene 0 with smooth edges: 3x3 samples a pixel."""
    check_picture(student, 0, "smooth")


@pytest.mark.check("tp5.scene.smooth_4")
def test_scene_smooth_4(student: Student) -> None:
    """Scene 4 with smooth edges: 3x3 samples a pixel."""
    check_picture(student, 4, "smooth")


@pytest.mark.check("tp5.scene.glass_7")
def test_scene_glass_7(student: Student) -> None:
    """Through the ball of glass and the ball of water of scene 7."""
    check_picture(student, 7, "glass")
