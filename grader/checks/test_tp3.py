"""TP3 - light and matter: Blinn-Phong, the sum of the lights, patterns.

`shade` and `direct_light` are judged without Fresnel; answers that have it already are accepted.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from grader.checking.comparison import far, unit
from grader.checking.expected_data import Array
from grader.checking.student import Answers, Student
from grader.checks.common import check_results

# So near the axis of a sphere, of radius 1, every direction is as good as another.
POLE = 1e-3

# ---- TP3.1: shade -------------------------------------------------------------------------------


@pytest.mark.check("tp3.shade.diffuse")
def test_shade_diffuse(student: Student) -> None:
    """Without specular colour: the light's colour times n.l times kd over pi."""
    check_results(student, "shade.diffuse")


@pytest.mark.check("tp3.shade.lobe")
def test_shade_lobe(student: Student) -> None:
    """Without diffuse colour: the specular lobe around h, with its factor (s + 8) / (8 pi)."""
    check_results(student, "shade.lobe")


@pytest.mark.check("tp3.shade.both")
def test_shade_both(student: Student) -> None:
    """Both parts together, in colour."""
    check_results(student, "shade.both")


@pytest.mark.check("tp3.shade.back")
def test_shade_back(student: Student) -> None:
    """A light behind the surface gives black."""
    check_results(student, "shade.back")


@pytest.mark.check("tp3.shade.far_lobe")
def test_shade_far_lobe(student: Student) -> None:
    """When h.n is negative the lobe adds nothing."""
    check_results(student, "shade.far_lobe")


# ---- TP3.2: direct_light ------------------------------------------------------------------------


@pytest.mark.check("tp3.direct_light.one")
def test_direct_light_one(student: Student) -> None:
    """With one light: what shade gives for the unit direction towards it."""
    check_results(student, "direct_light.one")


@pytest.mark.check("tp3.direct_light.sum")
def test_direct_light_sum(student: Student) -> None:
    """With several lights: the sum of what each gives."""
    check_results(student, "direct_light.sum")


@pytest.mark.check("tp3.direct_light.bright")
def test_direct_light_bright(student: Student) -> None:
    """The sum is not limited to 1."""
    check_results(student, "direct_light.bright")


@pytest.mark.check("tp3.direct_light.none")
def test_direct_light_none(student: Student) -> None:
    """Without any light: black."""
    check_results(student, "direct_light.none")


# ---- TP3.B1: checker_color, TP3.B2: texture_color -----------------------------------------------


@pytest.mark.check("tp3.checker_color.positive")
def test_checker_color_positive(student: Student) -> None:
    """Cubes of side 1 change colour along x, y and z."""
    check_results(student, "checker_color.positive")


@pytest.mark.check("tp3.checker_color.negative")
def test_checker_color_negative(student: Student) -> None:
    """On the negative side the cubes go on changing, without a double one at zero."""
    check_results(student, "checker_color.negative")


@pytest.mark.check("tp3.checker_color.placed")
def test_checker_color_placed(student: Student) -> None:
    """The pattern starts at pattern_origin, with cubes of side pattern_size."""
    check_results(student, "checker_color.placed")


@pytest.mark.check("tp3.texture_color.texel")
def test_texture_color_texel(student: Student) -> None:
    """Around the unit sphere, each direction has its texel."""
    check_results(student, "texture_color.texel")


@pytest.mark.check("tp3.texture_color.scaled")
def test_texture_color_scaled(student: Student) -> None:
    """The sphere may be anywhere and of any size."""
    check_results(student, "texture_color.scaled")


@pytest.mark.check("tp3.texture_color.seam")
def test_texture_color_seam(student: Student) -> None:
    """At the poles and on the seam, a texel of the image's border is read, none outside it."""
    for trial in student.trials("texture_color.seam"):
        got = trial.got("result")
        wrong = [
            far(np.broadcast_to(color, texels.shape), texels, 1e-5).all()
            for color, texels in zip(got, border(trial), strict=True)
        ]
        trial.complain(np.array(wrong), "failure.no_texel", got=got)


def border(trial: Answers) -> Iterator[Array]:
    """Return the texels that each call may give: the ends of a row, or at a pole all of it."""
    texels, args = trial.batch.globals["texels"], trial.batch.args
    way = unit(args["p"].astype(np.float64) - args["mat"]["pattern_origin"])
    height = len(texels)
    for x, y, z in way:
        row = min(int(np.arccos(np.clip(y, -1, 1)) / np.pi * height), height - 1)
        yield texels[row] if np.hypot(x, z) < POLE else texels[row, [0, -1]]


@pytest.mark.check("tp3.texture_color.missing")
def test_texture_color_missing(student: Student) -> None:
    """Without a texture: kd."""
    check_results(student, "texture_color.missing")
