"""Checks that are a line of exercises.toml: what is wrong in one is told by its name."""

from __future__ import annotations

from pathlib import Path

import pytest

from grader.checks.lines import act_of
from grader.course.exercises import MANIFEST, Line, ManifestError, load

LINE = '"tp2.camera_ray.exact" = { weight = 1, helper = "camera.check_directions", suites = ['


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ('compare = ["result"]', "has an unknown key, compare"),
        ('compares = ["result"]', ": suites go with compares or helper"),
        ('suites = ["a.b"]', ": suites go with compares or helper"),
        ('suites = "a.b", compares = ["result"]', ": suites is a list"),
        ('picture = "scene0.flat", helper = "solids.check_meets"', "has helper and picture: keep"),
    ],
)
def test_a_malformed_line_is_refused(tmp_path: Path, line: str, told: str) -> None:
    """Rather than read as something else."""
    text = MANIFEST.read_text(encoding="utf-8")
    start = text.index(LINE)
    end = text.index("\n", start)
    path = tmp_path / "exercises.toml"
    own = f'"tp2.camera_ray.exact" = {{ weight = 1, {line} }}'
    path.write_text(text[:start] + own + text[end:], encoding="utf-8")
    with pytest.raises(ManifestError) as error:
        load(path)
    assert told in str(error.value)
    assert "exercises.toml" in str(error.value)
    assert "tp2.camera_ray.exact" in str(error.value)


@pytest.mark.parametrize(
    ("line", "told"),
    [
        (Line(helper="solids.check_mets", suites=("a.b",)), "the nearest is solids.check_meets"),
        (Line(helper="solid.check_meets", suites=("a.b",)), "there is no grader/checks/solid.py"),
        (Line(picture="scene4.shadow"), "the nearest is scene4.shadows"),
    ],
)
def test_an_unknown_name_is_told_with_the_nearest(line: Line, told: str) -> None:
    """Of a helper, its module, or a picture."""
    with pytest.raises(ManifestError, match=rf"^exercises\.toml: tp9\.x\.y: .*{told}"):
        act_of("tp9.x.y", line)
