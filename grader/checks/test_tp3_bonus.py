"""TP3, bonus: checkerboards and textures."""

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

# ---- TP3.B1: checker_color, TP3.B2: texture_color -----------------------------------------------


@pytest.mark.check("tp3.texture_color.seam")
def test_texture_color_seam(student: Student) -> None:
    """At the poles and on the seam, a texel of the image's border is read, none outside it."""
    expect_texels(student)
    for trial in student.trials("texture_color.seam"):
        got = trial.got("result")
        wrong = [
            far(np.broadcast_to(color, texels.shape), texels, 1e-5).all()
            for color, texels in zip(got, border(trial), strict=True)
        ]
        trial.complain(np.array(wrong), "failure.no_texel", got=got)


def expect_texels(student: Student) -> None:
    """Raise Wrong unless the texels of an image are read, in whatever order."""
    for trial in student.trials("texture_color.texel"):
        texels = trial.batch.globals["texels"].reshape(-1, 3)
        got = trial.got("result")
        near = np.abs(got[:, None].astype(np.float64) - texels).max(axis=2)
        if len(np.unique(near.argmin(axis=1)[near.min(axis=1) < 1e-4])) < len(texels) / 4:
            trial.expect("result")


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
    expect_texels(student)
    check_results(student, "texture_color.missing")
