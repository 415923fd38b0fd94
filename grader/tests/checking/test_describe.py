"""How a call is told: in C's own names, with what it was run in."""

from __future__ import annotations

import numpy as np
import pytest

from grader.checking.describe import setting
from grader.checking.expected_data import Batch

POINT = [("x", "f4"), ("y", "f4"), ("z", "f4")]
CAMERA = np.array((((0, 0, 2)), 90), [("position", POINT), ("fov", "f4")])
OPTIONS = np.array((3, True), [("samples", "i4"), ("shading", "?")])


@pytest.mark.parametrize("function", ["camera_ray", "raytrace", "pixel_color"])
def test_what_a_picture_depends_on_is_told(function: str) -> None:
    """Its size, the camera, and how many samples a pixel has when that is not one."""
    batch = Batch(function, {}, {"theCamera": CAMERA, "options": OPTIONS}, (), 1e-4)
    said = setting(batch)
    assert "WIDTH = 96, HEIGHT = 64" in said
    assert "theCamera: {position" in said
    assert "fov 90" in said
    assert "options.samples = 3" in said


@pytest.mark.parametrize(
    ("function", "name", "words"),
    [("intersect_scene", "scene", "object_count"), ("direct_light", "lights", "num_lights")],
)
def test_what_is_too_long_to_show_is_counted(function: str, name: str, words: str) -> None:
    """By the name that C has for it."""
    items = np.zeros(200, [("x", "f4")])
    assert setting(Batch(function, {}, {name: items}, (), 1e-4)) == f" [{words} = 200]"


def test_what_does_not_matter_is_not_told() -> None:
    """An intersection has no camera."""
    batch = Batch("intersect_sphere", {}, {"theCamera": CAMERA, "options": OPTIONS}, (), 1e-4)
    assert setting(batch) == ""
