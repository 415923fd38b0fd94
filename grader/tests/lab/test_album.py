"""My pictures: what scene 0 looked like after each exercise that is right."""

from __future__ import annotations

import json
from pathlib import Path

from grader.lab import check, progress
from grader.lab.cells import album
from grader.lab.display.links import outputs
from grader.tests.lab.conftest import Edit

DOT = "float n_l = vector_dot(n, l);"


def kept() -> dict[str, str]:
    """Return the pictures that were kept, by exercise."""
    path = outputs() / "lab" / album.FILE
    content: dict[str, str] = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    return content


def test_an_exercise_that_is_right_leaves_a_picture(folder: Path, edit: Edit) -> None:
    """One each, in the course's order; what is wrong leaves the one from before."""
    assert album.strip() is None
    check("TP3.1")
    check("TP2.2")
    first = kept()
    assert set(first) == {"TP2.2", "TP3.1"}
    html = progress().html
    assert html.index("Scene 0 after TP2.2.") < html.index("Scene 0 after TP3.1.")
    assert "Your pictures of scene 0: TP2.2, TP3.1." in progress().text
    edit("raytracer.c", DOT, "float n_l = -vector_dot(n, l);")
    check("TP3.1")
    assert kept() == first
    check("TP2.2")  # right still: what it draws has changed with the rest
    assert kept()["TP2.2"] != first["TP2.2"]


def test_no_picture_is_no_trouble(folder: Path, edit: Edit) -> None:
    """Neither a TP without scenes, nor a crash elsewhere, nor a damaged file stops a check."""
    check("TP1.1")
    assert kept() == {}
    edit("raytracer.c", DOT, f"{DOT} volatile int *p = 0; *p = 1;")
    assert "right" in check("TP2.4").text
    assert kept() == {}
    path = outputs() / "lab" / album.FILE
    path.write_text('{"TP2.4": "no picture"}', encoding="utf-8")
    assert "Scene 0 after" not in progress().html
    path.write_text("no JSON", encoding="utf-8")
    assert album.strip() is None
