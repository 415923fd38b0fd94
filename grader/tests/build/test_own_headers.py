"""A wrong prototype in the student's own header costs the functions that it is about, no more."""

from __future__ import annotations

from pathlib import Path

import pytest

from grader.build.own_headers import without_changed
from grader.course.exercises import load
from grader.tests.support.judging import judge, solution

ERROR = (
    "raytracer.h:{line}:{column}: error: conflicting types for ‘{name}’; have ‘int(int)’\n{code}\n"
)
HEADER = """\
#include "exercises.h"
#define HALF 0.5f
typedef struct pair_s { float low; } pair; bool intersect_sphere(
    ray *r, intersection *it, object *obj); float twice(float x);
int in_shadow(const intersection *it, const light *from);
"""


def said(line: int, name: str) -> str:
    """Return what a compiler says of a name in a line of the header."""
    text = HEADER.splitlines()[line - 1]
    column = text.index(name) + 1
    return ERROR.format(line=line, column=column, name=name, code=f"    {line} | {text}")


def test_what_files_need_of_a_header_stays(cache: Path) -> None:
    """Its types and constants too: all the points but those of the two functions."""
    files = solution()
    files["raytracer.h"] = files["raytracer.h"].replace('#include "exercises.h"\n', HEADER)
    body = "pair half = {HALF};\n    return ratio * ratio * half.low * 2.f;"
    files["raytracer.c"] = files["raytracer.c"].replace("return ratio * ratio;", body)
    assert body in files["raytracer.c"]
    checks = judge(files, cache, keyword="tp1.fill_red or tp2.intersect or tp4.in_shadow or tp5.re")
    rules = load()
    lost = {rules.exercise(each.exercise).id for each in checks.values() if not each.points}
    assert lost == {"TP2.4", "TP4.1"}
    assert all(each.points in (0, each.max_points) for each in checks.values())
    told = checks["tp4.in_shadow.blocked"].message
    assert "conflicting types" in told
    assert "; the other files are judged all the same" in told


def test_only_the_declarations_in_error_go() -> None:
    """The lines keep their numbers, and what else stands in them stays."""
    errors = said(3, "intersect_sphere") + said(5, "in_shadow")
    rest = without_changed(HEADER.encode(), errors)
    assert rest is not None
    lines = [line.strip() for line in rest.decode().splitlines()]
    assert lines == [
        *('#include "exercises.h"', "#define HALF 0.5f"),
        *("typedef struct pair_s { float low; } pair;", "float twice(float x);", ""),
    ]


@pytest.mark.parametrize(
    "errors",
    [
        "",
        "raytracer.h:2:1: error: unknown type name ‘bool’\n",
        said(5, "in_shadow") + "raytracer.h:2:1: error: unknown type name ‘bool’\n",
        ERROR.format(line=99, column=1, name="in_shadow", code="    99 | int in_shadow(int);"),
        ERROR.format(line=2, column=9, name="HALF", code="    2 | #define HALF 0.5f"),
    ],
)
def test_a_header_with_another_fault_is_left_out_whole(errors: str) -> None:
    """So is one in which the declaration is not where it is said to be."""
    assert without_changed(HEADER.encode(), errors) is None
