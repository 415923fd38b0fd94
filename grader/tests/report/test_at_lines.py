"""What is wrong at its line, for editors and for GitHub Actions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from grader.commands import ANNOTATIONS
from grader.report import at_lines
from grader.tests.report.test_terminal import check, content, exercise

CODE = """\
#include "raytracer.h"
void f2(color *img);
void f1(color *img) {
    f2(img);
}
void f2(color *img) {
    img[0].x = 1;
}
"""


@pytest.fixture
def graded(tmp_path: Path) -> dict[str, Any]:
    """Return results of a file with a wrong function, one that dies, a warning and an error."""
    path = tmp_path / "main.c"
    path.write_text(CODE, encoding="utf-8")
    rows = [check(1, "failed", location=""), check(1, "failed", "b", location="")]
    error = {"file": "octree.c", "line": 7, "lines": ["octree.c:7: error: x"], "meaning": "Quoi ?"}
    build = {"ok": False, "warnings": [], "log": "", "errors": [error], "rejected": {}}
    build["advice"] = ["main.c:7 : la variable x ne sert jamais (f2)."]
    sources = [
        {"name": name, "path": str(tmp_path / name), "modified": "2026-03-02T07:00:00+01:00"}
        for name in ("main.c", "octree.c")
    ]
    return content(
        (exercise(1, "failed", 0), rows),
        (exercise(2, "crashed", 0), [check(2, "crashed", location="main.c:7")]),
        (exercise(3, "passed", 4), [check(3, "passed", location="")]),
        build=build,
        submission={"name": "rendu", "files": {}, "sources": sources, "nearby": []},
    )


def test_an_editor_reads_them_as_a_compilers(graded: dict[str, Any], tmp_path: Path) -> None:
    """Errors first; a failure where its function begins, or where it died; one for an exercise."""
    assert at_lines.lines(graded, "editor") == [
        f"{tmp_path}/octree.c:7: error: Quoi ?",
        f"{tmp_path}/main.c:3: error: TP1.1 f1 - message a Question ?",
        f"{tmp_path}/main.c:7: error: TP1.2 f2 - message a Question ?",
        f"{tmp_path}/main.c:7: warning: la variable x ne sert jamais (f2).",
    ]


def test_a_workflow_command_is_one_line_whatever_it_says(graded: dict[str, Any]) -> None:
    """Line ends, commas and colons are escaped; a sentence cannot be taken for another command."""
    for each in graded["submission"]["sources"]:
        each["path"] = f"core_c/a,b:c/{each['name']}"
    graded["checks"][0]["message"] = "100 %\n::error::forged"
    lines = at_lines.lines(graded, "github")
    assert lines[1] == (
        "::error file=core_c/a%2Cb%3Ac/main.c,line=1,title=TP1.1 f1::"
        "100 %25%0A::error::forged%0AQuestion ?"
    )
    assert all("\n" not in each for each in lines)


def test_a_file_that_cannot_be_read_is_named_all_the_same(graded: dict[str, Any]) -> None:
    """As one in an archive: its first line."""
    graded["submission"]["sources"][0]["path"] = "rendu.zip/main.c"
    assert at_lines.lines(graded, "editor")[1].startswith("rendu.zip/main.c:1: error: TP1.1")


def test_the_command_line_knows_every_form() -> None:
    """It has their names without loading what writes them."""
    assert {*ANNOTATIONS} == {*at_lines.FORMS}
