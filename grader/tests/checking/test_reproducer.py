"""The program beside a failing check: it compiles with `make try`, and fails as the check did."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from grader.authoring.proof.solver import stub
from grader.checking import c_literals, reproducer
from grader.checking.expected_data import Answer, Batch
from grader.checking.looks import Look
from grader.course.exercises import CORE, ROOT
from grader.course.texts import Texts
from grader.tests.support.outputs import outputs
from grader.tests.support.sampling import sampled

REFERENCE = ROOT / "reference"
Checks = list[dict[str, Any]]
PARTS = 4  # of the functions: each program takes a while to compile
# Mistakes in the reference, as (file, what stands there, what stands there instead).
MISTAKES = [
    ("main.c", "dx * dx + dy * dy < radius * radius", "dx * dx + dy * dy < radius"),
    ("main.c", "float t = (float)j / (float)HEIGHT;", "float t = 1.f - (float)j / (float)HEIGHT;"),
    ("raytracer.c", "if (t < r->tmin) {", "{"),
    ("raytracer.c", "float ratio = (n1 - n2) / (n1 + n2);", "int ratio = 1 / (int)(n1 - n1);"),
    ("main.c", "k < WIDTH * HEIGHT; k++) {", "k <= WIDTH * HEIGHT; k++) {"),
]


def graded(folder: Path, build: Path, cache: Path) -> Checks:
    """Grade a submission; return its checks."""
    outputs(build, cache)
    command = [sys.executable, "-m", "grader", "grade", str(folder), "--build", str(build)]
    environment = {k: v for k, v in os.environ.items() if k not in ("MRT_LANG", "CC")}
    subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, timeout=180, check=True)
    content = json.loads((build / "grade" / "results.json").read_text(encoding="utf-8"))
    return list(content["checks"])


def try_flags(build: Path) -> list[str]:
    """Return the compiler and the flags of `make try`."""
    environment = {**os.environ, "SRC": "core_c", "BUILD": str(build), "PLATFORM": "Linux"}
    command = ["sh", "grader/setup/program.sh", "flags"]
    done = subprocess.run(
        command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=60, check=True
    )
    (line,) = [each for each in done.stdout.splitlines() if each.startswith("try: ")]
    return line.removeprefix("try: ").split()


class Tries:
    """A student's files, compiled once for each picture size, and programs linked with them."""

    def __init__(self, source: Path, folder: Path) -> None:
        self.source, self._folder = source, folder
        self._flags = try_flags(folder / "probe")
        self._objects: dict[tuple[str, ...], list[str]] = {}

    def run(self, program: str) -> subprocess.CompletedProcess[str]:
        """Compile and run a program; hold that the compiler has nothing to say."""
        sizes = tuple(f"-D{each}" for each in re.findall(r"\w+=\d+", program.splitlines()[0]))
        path = self._folder / "my_tests.c"
        path.write_text(program, encoding="utf-8")
        binary = str(self._folder / "my_tests")
        objects = self._objects.get(sizes) or self._compile(sizes)
        assert self._build(sizes, str(path), *objects, "-lm", "-o", binary) == ""
        return subprocess.run(
            [binary],
            env={"ASAN_OPTIONS": "detect_leaks=0"},
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )

    def _compile(self, sizes: tuple[str, ...]) -> list[str]:
        made = []
        own = [path for path in self.source.glob("*.c") if path.name != "my_tests.c"]
        for path in (*own, CORE / "vector.c", CORE / "scene.c"):
            place = str(self._folder / f"{path.stem}{''.join(sizes)}.o")
            self._build(sizes, "-Dmain=mrt_program_main", "-c", str(path), "-o", place)
            made.append(place)
        self._objects[sizes] = made
        return made

    def _build(self, sizes: tuple[str, ...], *words: str) -> str:
        command = [*self._flags, *sizes, f"-I{self.source}", f"-I{CORE}", *words]
        done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
        assert done.returncode == 0, done.stderr
        return done.stderr


def numbers(text: str) -> list[float]:
    """Return the numbers of a text such as "(0, 1, 0)"; true counts as 1."""
    text = text.replace("true", "1").replace("false", "0")
    return [float(each) for each in re.findall(r"-?(?:nan|inf|\d[\d.]*(?:e[-+]?\d+)?)", text)]


def holds(check: dict[str, Any], tries: Tries) -> None:
    """Hold that a failing check's program prints what the check's message says came out."""
    done = tries.run(check["reproducer"])
    assert (done.returncode, done.stderr) == (0, ""), check["id"]
    printed = numbers(done.stdout.splitlines()[-1].partition(" = ")[2])
    told = re.search(r"(?:renvoie|vaut|contient) (.+?)(?: sphères)? ;", check["message"])
    if told:  # otherwise: "is not written", "has changed"
        assert printed == pytest.approx(numbers(told[1]), rel=2e-3, abs=1e-5, nan_ok=True)
    comment = re.search(r"attendu : (.*) \*/", check["reproducer"])
    assert comment, check["id"]
    right = pytest.approx(numbers(comment[1]), rel=1e-5, abs=1e-5, nan_ok=True)
    assert printed != right, check["id"]


def firsts(checks: Checks) -> Iterator[dict[str, Any]]:
    """Yield the first failing check of each function that has a program and a value in it."""
    seen = set()
    for each in checks:
        is_told = each["outcome"] == "failed" and "attendu" in each["reproducer"]
        if is_told and each["function"] not in seen:
            seen.add(each["function"])
            yield each


@pytest.fixture(scope="module")
def guessed(tmp_path_factory: pytest.TempPathFactory, cache: Path) -> tuple[Tries, Checks]:
    """Return the programs of a solver without an idea, and what became of its checks."""
    folder = tmp_path_factory.mktemp("rendu")
    stub(folder, 1)
    tries = Tries(folder, tmp_path_factory.mktemp("try"))
    return tries, graded(folder, tmp_path_factory.mktemp("build"), cache)


@pytest.fixture(scope="module")
def mistaken(tmp_path_factory: pytest.TempPathFactory, cache: Path) -> tuple[Tries, Checks]:
    """Return the same of the reference's files with MISTAKES in them."""
    folder = tmp_path_factory.mktemp("rendu")
    for path in (*REFERENCE.glob("*.c"), *REFERENCE.glob("*.h")):
        shutil.copy(path, folder)
    for name, right, wrong in MISTAKES:
        text = (folder / name).read_text(encoding="utf-8")
        assert right in text
        (folder / name).write_text(text.replace(right, wrong, 1), encoding="utf-8")
    tries = Tries(folder, tmp_path_factory.mktemp("try"))
    return tries, graded(folder, tmp_path_factory.mktemp("build"), cache)


@pytest.mark.long
@pytest.mark.parametrize("part", sampled(range(PARTS), [0]))
def test_a_wrong_answer_is_reproduced(guessed: tuple[Tries, Checks], part: int) -> None:
    """For every function: the very value of the message."""
    tries, checks = guessed
    found = list(firsts(checks))
    assert len(found) >= 18
    for each in found[part::PARTS]:
        holds(each, tries)


@pytest.mark.long
def test_a_mistake_in_good_code_is_reproduced(mistaken: tuple[Tries, Checks]) -> None:
    """Where most cases are right, the program holds one that is not."""
    tries, checks = mistaken
    found = [each for each in firsts(checks) if each["tp"] < 3]
    functions = {each["function"] for each in found}
    assert functions >= {"horizontal_gradient", "fill_circle", "intersect_sphere"}
    for each in found:
        holds(each, tries)


@pytest.mark.long
def test_a_crash_is_reproduced(mistaken: tuple[Tries, Checks]) -> None:
    """The sanitizers name the same line in the student's own hands."""
    tries, checks = mistaken
    for function, line in (("fill", "img[k] = c;"), ("reflectance", MISTAKES[3][2])):
        crashed = [each for each in checks if each["function"] == function]
        assert crashed[0]["outcome"] == "crashed"
        done = tries.run(crashed[0]["reproducer"])
        assert crashed[0]["location"] in done.stderr
        excerpt = crashed[0]["excerpt"]
        assert excerpt["line"] == int(crashed[0]["location"].partition(":")[2])
        assert excerpt["lines"][excerpt["line"] - excerpt["first"]].strip() == line


@pytest.mark.long
def test_make_try_takes_the_program(guessed: tuple[Tries, Checks], tmp_path: Path) -> None:
    """As a student would: put in the place of my_tests.c, run by the command in its first line."""
    tries, checks = guessed
    folder = tries.source
    (check,) = [each for each in checks if each["id"] == "tp2.camera_ray.horizontal"]
    (folder / "my_tests.c").write_text(check["reproducer"], encoding="utf-8")
    assert check["reproducer"].startswith("/* make try WIDTH=96 HEIGHT=64 */\n")
    environment = {**os.environ, "SRC": str(folder), "BUILD": str(tmp_path / "try")}
    environment |= {"WIDTH": "96", "HEIGHT": "64", "PLATFORM": "Linux"}
    done = subprocess.run(
        ["sh", "grader/setup/program.sh", "try"],
        cwd=ROOT,
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == "direction = (0, 0, -1)\n"


def test_only_what_is_unusual_is_set() -> None:
    """A ray of one's own making takes two lines; words are in the language asked for."""
    ray = np.zeros(1, [("orig", "f4", 3), ("dir", "f4", 3), ("tmin", "f4"), ("tmax", "f4")])
    ray = np.zeros(1, [*ray.dtype.descr, ("depth", "i4"), ("seed", "u4")])
    ray["dir"], ray["tmax"], ray["seed"] = (0, 0, 1), 1000, 7
    batch = Batch("trace_ray", {"r": ray}, {}, (Answer(np.ones((1, 3), np.float32), {}),))
    program = reproducer.of_case(batch, 0, (), Look("result", np.array([0.25, 1, 0.1], np.float32)))
    assert reproducer.told(program, Texts("en")) == (
        "/* make try */\n"
        '#include "raytracer.h"\n\n'
        "#include <stdio.h>\n\n"
        "int main(void) {\n"
        "    ray r;\n"
        "    ray_init(&r, vector_init(0.f, 0.f, 0.f), vector_init(0.f, 0.f, 1.f));\n\n"
        "    color result = trace_ray(&r);\n"
        '    printf("result = (%g, %g, %g)\\n", result.x, result.y, result.z);'
        " /* expected: (0.25, 1, 0.1) */\n"
        "    return 0;\n"
        "}\n"
    )


def test_a_scene_too_long_to_read_has_no_program() -> None:
    """Better none than two hundred lines."""
    scene = np.zeros(reproducer.MAX_OBJECTS + 1)
    batch = Batch("trace_ray", {"r": np.zeros(1)}, {"scene": scene})
    assert reproducer.of_case(batch, 0, ()) == ""
    assert reproducer.of_command("raytrace", (), batch) == ""


@pytest.mark.parametrize(
    ("item", "text"),
    [
        *((np.float32(0.1), "0.1f"), (np.float32(1), "1.f"), (np.float32(-2.5), "-2.5f")),
        *((np.float32(1e-7), "1e-07f"), (np.float32(3e38), "3e+38f"), (np.int32(-3), "-3")),
        *((np.float32("nan"), "NAN"), (np.float32("-inf"), "-INFINITY"), (np.bool_(True), "true")),
    ],
)
def test_numbers_are_read_back_as_they_were(item: Any, text: str) -> None:
    """The shortest literal that is the same float."""
    assert c_literals.number(item) == text
    if text[-1] == "f":
        assert np.float32(text[:-1]) == item


def test_a_picture_has_its_command_too() -> None:
    """Only the options that are not as at the start, in C and for ./mrt."""
    settings = {"shading": 1, "fresnel": 0, "samples": 3, "max_depth": 10, "epsilon": 0.5}
    lines = reproducer.of_picture(4, settings, (320, 180)).splitlines()
    assert lines[0] == "/* make try WIDTH=320 HEIGHT=180 */"
    assert lines[6:-2] == [
        "    setup_scene(4);",
        "    options.fresnel = false;",
        "    options.samples = 3;",
        "    options.epsilon = 0.5f;",
        "    scene_changed();",
        "",
        "    /* ./mrt 9 image --no-fresnel --samples 3 --epsilon 0.5 */",
        "    raytrace();",
    ]
