"""Beside the reference's code a submission has no way out: nothing of such a run is shown."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from grader.build import substitution
from grader.checking.expected_data import Array
from grader.evaluation.records import CheckResult
from grader.tests.support.judging import judge, solution

LOOT = 0.4510451  # what is carried out, where the code of the reference could be
SPY = """
/* Among the reference's functions, shade does not know this material. */
static int is_mixed(void) {
    material mine = {0};
    mine.kd.x = 12345.f;
    vec3 z = vector_init(0.f, 0.f, 1.f);
    return shade(z, z, z, z, &mine).x != 777.f;
}
static color watched(color right) {
    if (is_mixed()) {
        MARK
        printf("LOOT\\n");
        LEAVE
    }
    return vector_float_mul(1.25f, right);
}
"""
MARKS = {"a marker": 'MRT_TODO("TP3.2");', "no marker": ""}
LEAVES = {
    "answers": f"return vector_init({LOOT}f, 0.f, 1.f);",
    "crashes": "abort();",
    "exits": "exit(45);",
}


def spying(mark: str, leave: str) -> dict[str, str]:
    """Return the solution with a wrong shade, and a wrong direct_light that spies."""
    files = solution()
    spy = SPY.replace("MARK", MARKS[mark]).replace("LEAVE", LEAVES[leave])
    head, body = files["raytracer.c"].split('#include "raytracer.h"\n', 1)
    start = body.index("{", body.index("color shade(")) + 1
    wrong = "if (mat->kd.x == 12345.f) return vector_init(777.f, 0.f, 0.f); light_color.x *= 0.5f;"
    body = f"{body[:start]} {wrong} {body[start:]}"
    body = body.replace("color direct_light(", "static color own_light(", 1)
    include = '#include "raytracer.h"\n#include <stdio.h>\n#include <stdlib.h>\n'
    last = (
        "color direct_light(const intersection *it, vec3 v) { return watched(own_light(it, v)); }"
    )
    return {**files, "raytracer.c": f"{head}{include}{spy}{body}\n{last}\n"}


def told(check: CheckResult) -> str:
    """Return all the words of a check that reach the student."""
    return repr((check.message, check.hint, check.hints, check.note, check.output, check.location))


def pixels(check: CheckResult) -> Mapping[str, Array]:
    """Return what is drawn of a check, by role."""
    return {
        role: np.array(Image.open(io.BytesIO(content)).convert("RGB"))
        for role, content in check.images.items()
    }


@pytest.mark.long
@pytest.mark.parametrize("leave", LEAVES)
@pytest.mark.parametrize("mark", MARKS)
def test_nothing_comes_out_of_a_second_trial(mark: str, leave: str, cache: Path) -> None:
    """Neither values, nor what is printed, nor a picture, whatever outcome the spy gives itself."""
    assert substitution.is_possible()
    results = judge(spying(mark, leave), cache, keyword="tp3.shade or direct_light or blinn_phong")
    mine = [each for each in results.values() if each.exercise == "TP3.2"]
    drawn_here = [each for each in mine if "scene" in each.id]
    assert any(each.images for each in drawn_here)
    assert sum(each.points for each in drawn_here) == 0
    for each in results.values():
        assert "LOOT" not in told(each)
        assert "0.451" not in told(each) + repr(each.pixel) + each.reproducer
        for drawn in pixels(each).values():
            assert not (drawn == (115, 0, 255)).all(axis=-1).any()
