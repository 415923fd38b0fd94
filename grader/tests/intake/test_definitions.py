"""What has changed between two versions of the files."""

from __future__ import annotations

import pytest

from grader.intake import definitions

BEFORE = {
    "main.c": "/* TP1 */\nvoid fill_red(void) {\n    fill(RED); /* all */\n}\n",
    "raytracer.c": "color shade(int a) {\n    return black;\n}\n",
}


@pytest.mark.parametrize(
    ("file", "old", "new", "ids"),
    [
        ("main.c", "RED", "BLUE", ["TP1.1"]),
        ("raytracer.c", "black", "white", ["TP3.1", "TP5.2"]),
        ("main.c", "all */", "of it, in red */", []),
        ("main.c", "    fill(RED);", "  fill(RED);\n\n", []),
        ("main.c", "/* TP1 */", "#define RED 1", []),
        ("main.c", "void fill_red(void) {", "int nothing_of_the_course(void) {", ["TP1.1"]),
    ],
    ids=["one", "two exercises in it", "a comment", "space", "outside", "gone"],
)
def test_the_exercises_of_the_functions_that_changed(
    file: str, old: str, new: str, ids: list[str]
) -> None:
    """Of each function that says something else; comments and spaces say nothing."""
    now = {**BEFORE, file: BEFORE[file].replace(old, new)}
    assert [each.id for each in definitions.changed(BEFORE, now)] == ids
    assert [each.id for each in definitions.changed(now, BEFORE)] == ids
