"""check() and what an earlier exercise has spoilt: the same verdict as a whole grade's."""

from __future__ import annotations

from pathlib import Path

import pytest

from grader.authoring.specimens.half_written import just_reached
from grader.intake import originals
from grader.lab import check, help_card, progress
from grader.tests.lab.conftest import Edit


@pytest.fixture(autouse=True)
def student_copy(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Let there be no solution to judge among."""
    monkeypatch.setattr(originals, "REFERENCE", tmp_path / "nowhere")


@pytest.mark.long
def test_what_an_earlier_exercise_spoils_waits(folder: Path, edit: Edit) -> None:
    """trace_ray is right, and intersect_sphere is not: the card and the next step say so."""
    edit(
        "raytracer.c",
        "vec3 from_center = vector_minus(r->orig, obj->center);",
        "vec3 from_center = vector_minus(obj->center, r->orig);",
    )
    shown = check("TP2.6").text
    assert shown.startswith("○ TP2.6 trace_ray: waiting, 0 / 5")
    assert "To be looked at after TP2.4" in shown
    assert "Next step: TP2.4, the function intersect_sphere" in shown
    assert "TP2.4 intersect_sphere" in help_card().text
    assert "Next step: TP2.4" in progress().text


def test_right_so_far(folder: Path) -> None:
    """What can be judged of raytrace before trace_ray is there counts, and is called right."""
    for name, text in just_reached("TP2.2").items():
        (folder / name).write_text(text, encoding="utf-8")
    shown = check("TP2.2").text
    assert shown.startswith("○ TP2.2 raytrace: right so far, 2.67 / 4")
    assert "Next step: TP2.3" in shown
    assert "right so far" in progress().text
