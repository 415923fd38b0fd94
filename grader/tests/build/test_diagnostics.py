"""What a compiler's message means, be it gcc's or clang's, in the student's language."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from grader.build import diagnostics, toolchain
from grader.build.records import Target
from grader.course.exercises import CORE
from grader.course.message import Message
from grader.course.texts import LANGUAGES, Texts
from grader.tests.support.judging import solution

COMPILERS = ("gcc", "clang")
TARGET = Target(96, 64)


def said(source: str, compiler: str, folder: Path) -> str:
    """Return what a compiler says of raytracer.c, with the flags of a build."""
    if shutil.which(compiler) is None:
        assert "MRT_CI" not in os.environ, f"{compiler} is not installed"
        pytest.skip(f"{compiler} is not installed")
    (folder / "raytracer.c").write_text(source, encoding="utf-8")
    flags = toolchain.compile_flags(toolchain.find_compiler(compiler), TARGET)
    command = [compiler, *flags, "-iquote", str(CORE), "-c", "raytracer.c", "-o", os.devnull]
    environment = {**os.environ, "LC_ALL": "C.UTF-8"}
    done = subprocess.run(
        command,
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    return done.stderr


def told(messages: list[Message]) -> list[tuple[str, object]]:
    """Return the keys of messages with the names that they tell."""
    return [(each.key.partition(".")[2], each.values["name"]) for each in messages]


# Each is one line of a function that begins as HEAD does, or declarations and such a function.
HEAD = '#include "exercises.h"\nint f(int a, vec3 v);\nint f(int a, vec3 v) {\n'
SYSTEM = "#include <stdlib.h>\n#include <stdio.h>"
WARNED = {
    "int k; k = a;": ("set_only", "k"),
    "int k;": ("unused_variable", "k"),
    "vector_add(v, v);": ("unused_result", "vector_add"),
    "v.x + 1.f;": ("no_effect", None),
    "unsigned u = 3; while (u >= 0) u--;": ("always", None),
    "int k = 1; if (a) { int k = 2; a += k; } a += k;": ("shadow", "k"),
    "{ float a = v.x; v.y = a; }": ("shadow", "a"),
    "if (a = 2) return 1;": ("assignment", None),
    "if (a > 1); a++;": ("empty_body", None),
    "if (a)\n        a++;\n        a--;": ("indentation", None),
    "return 0 < a < 3;": ("chained", None),
    "return abs(v.x) > 1.f;": ("absolute", "abs"),
    "return (a & 1) == (a & 1 == 0);": ("precedence", None),
    "if (!a == 2) return 1;": ("not", None),
    "int k; return k;": ("unset", "k"),
    "const int *q = &a; int *s = q; a = *s;": ("const", None),
    "float *p = &v; a = p[0] > 1.f;": ("wrong_type", None),
    "a = a++ + 1;": ("sequence", "a"),
    "char k = 300; a = k;": ("overflow", None),
    "if (a) if (a > 2) a = 3; else a = 4;": ("dangling_else", None),
    'printf("%d", v.x);': ("format", None),
    "return f(a - 1, v) + 1;": ("endless", None),
    "int *p = malloc(4); free(p); return *p;": ("freed", "p"),
    "switch (a) { case 1: a = 2; case 2: a = 3; }": ("fallthrough", None),
}
# These are of gcc's optimiser, or of other options.
NOT_BY_CLANG = ("always", "indentation", "chained", "freed", "fallthrough")
CASES = [(line, each) for line in WARNED for each in COMPILERS]


@pytest.mark.parametrize(
    ("line", "compiler"),
    [case for case in CASES if case[1] == "gcc" or WARNED[case[0]][0] not in NOT_BY_CLANG],
)
def test_a_warning_that_is_the_answer_is_told(line: str, compiler: str, tmp_path: Path) -> None:
    """One sentence, with the place, the name and, from gcc, the function; in both languages."""
    ends = "" if "return k" in line or "return 0" in line else " return a;"
    source = f"{HEAD}    {line}{ends} }}\n".replace("#include", f"{SYSTEM}\n#include", 1)
    found = diagnostics.advice(said(source, compiler, tmp_path))
    key, name = WARNED[line]
    (message,) = [each for each in found if each.key == f"advice.{key}"]
    assert name is None or message.values["name"] == name
    # A function without end is told at its head.
    place = f"raytracer.c:{5 if key == 'endless' else 6}"
    for language in LANGUAGES:
        assert Texts(language).say(message.key, **message.values).startswith(place)


@pytest.mark.parametrize("compiler", COMPILERS)
def test_a_local_variables_address_is_told(compiler: str, tmp_path: Path) -> None:
    """It is no more when the function has returned."""
    text = said("int *f(int a);\nint *f(int a) {\n    return &a;\n}\n", compiler, tmp_path)
    (message,) = diagnostics.advice(text)
    assert (message.key, message.values["place"]) == ("advice.local_address", "raytracer.c:3")


@pytest.mark.parametrize("compiler", COMPILERS)
def test_a_way_without_return_is_told(compiler: str, tmp_path: Path) -> None:
    """It has no name to tell, but a function."""
    text = said(f"{HEAD}    if (a) return 1;\n}}\n", compiler, tmp_path)
    (message,) = diagnostics.advice(text)
    assert message.key == "advice.no_return"
    assert message.values["where"] == (" (f)" if compiler == "gcc" else "")


SCENE = "bool hit = false;\n    for (int k"
BROKEN = {
    # A minus sign, a blank and a quotation mark as a PDF has them.
    ("object_count; k++", "object_count \u2212 0; k++"): ("stray", "\u2212"),
    ("bool hit = false;\n    for (int k", "bool hit =\u00a0false;\n    for (int k"): (
        "blank",
        "\u00a0",
    ),
    # A brace, a bracket, a semicolon lost; a semicolon too many.
    ("    return hit;\n    /* END SOLUTION */\n}\n\n/* TP2.6", "    return hit;\n/* TP2.6"): (
        "brace_in",
        "intersect_scene",
    ),
    ("+ obj->dist) / slope", "+ obj->dist / slope"): ("bracket", ")"),
    (SCENE, SCENE.replace(";", "")): ("semicolon", None),
    ("static const float PI = 3.14159265f;", "#define PI 3.14159265f;"): ("macro_semicolon", "PI"),
    ("vec3 outwards", "vec outwards"): ("unknown_type", "vec"),
    ("vector_minus(r->orig, obj->center)", "r->orig - obj->center"): ("operands", None),
    ("vector_minus(r->orig, obj->center)", "vector_minus(r->orig)"): ("arguments", None),
}


@pytest.mark.parametrize("change", BROKEN, ids=[str(name) for name, _ in BROKEN.values()])
def test_an_error_is_told_by_its_cause_alone(change: tuple[str, str], tmp_path: Path) -> None:
    """The first error is what was changed, in plain words, and what it drags along is not told."""
    old, new = change
    source = solution()["raytracer.c"]
    assert old in source
    found = diagnostics.errors(said(source.replace(old, new, 1), "gcc", tmp_path))
    meaning = found[0].meaning()
    key, name = BROKEN[change]
    assert meaning is not None
    assert meaning.key == f"build.{key}"
    assert name is None or meaning.values["name"] == name
    after = [each.meaning() for each in found[1:]]
    assert not {each.key for each in after if each} & {"build.brace", "build.brace_in"}
    assert all(each.place != found[0].place for each in found[1:])


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("comment", ["", " // a half", " /* a half */"])
def test_a_constant_with_a_semicolon_is_told_where_it_is_used(
    compiler: str, comment: str, tmp_path: Path
) -> None:
    """The error is behind it: the compiler has nothing to say against its definition."""
    header = f"#define HALF 0.5f;{comment}\n#define RETURN(x) return x;\n".encode()
    (tmp_path / "mine.h").write_bytes(header)
    source = '#include "mine.h"\nfloat f(float x) { x = x * HALF * 2.f; RETURN(x) }\n'
    output = said(source, compiler, tmp_path)
    assert diagnostics.with_macros(output, {}) == output
    found = diagnostics.errors(diagnostics.with_macros(output, {"mine.h": header}))
    assert [each.meaning() for each in found] == [
        Message("build.macro_semicolon", {"name": "HALF"})
    ]


ADDRESSES = {
    "ray_at(r, 1.f)": "value",
    "vector_add(ray_at(*r, 1.f), &r->dir)": "value",
    "trace_ray(*r)": "address",
    "surface_color(*it)": "address",
    "vector_float_mul(r.tmax, r->dir)": "arrow",
    "vector_float_mul(it->position->x, r->dir)": "dot",
}


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("call", ADDRESSES)
def test_a_value_and_its_address_are_told_apart(call: str, compiler: str, tmp_path: Path) -> None:
    """Which of the two is wanted, a star, an ampersand, a dot or an arrow."""
    head = "vec3 f(ray *r, const intersection *it);\nvec3 f(ray *r, const intersection *it)"
    for header in CORE.glob("*.h"):  # beside the code, as in a build
        shutil.copy(header, tmp_path)
    source = f'#include "raytracer.h"\n{head} {{ (void)it; return {call}; }}\n'
    found = [each.meaning() for each in diagnostics.errors(said(source, compiler, tmp_path))]
    assert [each.key for each in found if each] == [f"build.{ADDRESSES[call]}"]


def test_clangs_words_for_a_stray_character_are_known(tmp_path: Path) -> None:
    """It names the character by its number."""
    source = solution()["raytracer.c"].replace("object_count; k++", "object_count \u2212 0; k++")
    found = diagnostics.errors(said(source, "clang", tmp_path))
    meaning = found[0].meaning()
    assert meaning == Message("build.stray", {"name": "\u2212"})


@pytest.mark.parametrize("compiler", COMPILERS)
def test_what_is_handed_out_is_not_warned_of(compiler: str, tmp_path: Path) -> None:
    """Neither the skeleton's stubs nor the solution."""
    for text in ((CORE / "raytracer.c").read_text("utf-8"), solution()["raytracer.c"]):
        (tmp_path / "raytracer.h").write_text('#include "exercises.h"\n', encoding="utf-8")
        assert said(text, compiler, tmp_path) == ""
