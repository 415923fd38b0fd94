"""The checks of TP2 to TP5: who gets points, who does not, and what a wrong answer is told."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

from grader.authoring.proof.solver import TURNS, stub
from grader.authoring.skeleton import skeleton
from grader.course import exercises as manifest
from grader.tests.support import grading
from grader.tests.support.judging import judge, solution
from grader.tests.support.sampling import sampled

ROOT = Path(__file__).resolve().parents[3]
PROGRAM = Path(__file__).with_name("raytracer.c")  # written otherwise in every place
Grade = Callable[..., dict[str, Any]]


@pytest.fixture
def grade(cache: Path, tmp_path: Path) -> Grade:
    """Return a function that grades a folder and gives its results; builds are kept."""

    def run(folder: Path, *words: str, **settings: str) -> dict[str, Any]:
        done = grading.grade(folder, tmp_path / "build", cache, *words, settings=settings)
        assert (done.code, done.err) == (0, "")
        return done.results

    return run


def outcomes(results: Mapping[str, Any]) -> dict[str, str]:
    """Return the outcome of each check that did not pass."""
    return {
        each["id"]: each["outcome"] for each in results["checks"] if each["outcome"] != "passed"
    }


@pytest.fixture
def plain_compiler(tmp_path: Path) -> str:
    """Return a compiler that knows no sanitizer."""
    compiler = tmp_path / "cc-without-asan"
    answer = '-print-file-name=*) echo "${1#*=}" ;; *) exec gcc "$@" ;;'
    compiler.write_text(f'#!/bin/sh\ncase "$1" in {answer} esac\n', encoding="utf-8")
    compiler.chmod(0o755)
    return str(compiler)


@pytest.mark.parametrize("tp", sampled(["1", "2", "3", "4", "5"], ["1", "4"]))
def test_one_tp_alone_has_all_it_needs(grade: Grade, tp: str) -> None:
    """What is built for one TP's checks is enough for them."""
    results = grade(ROOT / "reference", "--tp", tp)
    assert results["checks"]
    assert outcomes(results) == {}


@pytest.mark.parametrize("compiler", sampled(["gcc", "clang", "plain"], ["gcc", "clang"], ["gcc"]))
def test_the_reference_passes_every_check(grade: Grade, compiler: str, plain_compiler: str) -> None:
    """In sanitized builds and in plain ones, of both compilers."""
    if compiler != "plain" and shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed")
    if compiler == "plain":
        # Nobody, as who a sandbox compiles when root asks, cannot read a test's folder.
        results = grade(ROOT / "reference", "--isolation", "portable", CC=plain_compiler)
    else:
        results = grade(ROOT / "reference", CC=compiler)
    assert outcomes(results) == {}
    assert (results["score"], results["bonus"]) == (100, 20)


def test_the_skeleton_is_all_to_do(grade: Grade, tmp_path: Path) -> None:
    """No point, and no failure: every check is `todo`."""
    folder = tmp_path / "core_c"
    folder.mkdir()
    arguments = ["--reference", str(ROOT / "reference"), "--out", str(folder)]
    assert skeleton.main(arguments) == 0
    results = grade(folder)
    assert (results["score"], results["bonus"]) == (0, 0)
    assert outcomes(results) == dict.fromkeys(manifest.load().checks(), "todo")


def write_part(folder: Path, solved: set[str]) -> None:
    """Write a submission in which some exercises are done, as in the reference."""
    known = [each.id for each in manifest.load().exercises]
    for name in manifest.load().student:
        lines, inside = [], False
        for line in (ROOT / "reference" / name).read_text(encoding="utf-8").splitlines():
            begin = re.search(r"BEGIN SOLUTION (TP[\dB.]+)", line)
            inside = inside or (begin is not None and begin[1] in solved)
            if not (inside and re.search("BEGIN SOLUTION|END SOLUTION", line)):
                lines.append(line)
            inside = inside and "END SOLUTION" not in line
        text = skeleton.make_skeleton(Path(name), "\n".join(lines), known)
        (folder / name).write_text(text, encoding="utf-8")


@pytest.mark.long
@pytest.mark.parametrize("done", sampled([2, 4], [4]))
def test_who_has_come_to_a_tp_loses_nothing_by_the_next(
    grade: Grade, tmp_path: Path, done: int
) -> None:
    """Every check of the TPs that are done passes; every other one is to do, none failed."""
    exercises = manifest.load().exercises
    solved = {each.id for each in exercises if each.tp <= done and not each.bonus}
    write_part(tmp_path, solved)
    todo = [check.id for each in exercises if each.id not in solved for check in each.checks]
    assert outcomes(grade(tmp_path)) == dict.fromkeys(todo, "todo")


@pytest.mark.long
def test_what_goes_through_another_exercise_is_judged(grade: Grade, tmp_path: Path) -> None:
    """Without intersect_scene, only its own checks are lost: the reference's stands in."""
    exercises = manifest.load().exercises
    write_part(tmp_path, {each.id for each in exercises} - {"TP2.5"})
    own = [check.id for check in manifest.load().exercise("TP2.5").checks]
    assert outcomes(grade(tmp_path)) == dict.fromkeys(own, "todo")


@pytest.mark.long
@pytest.mark.parametrize("turn", sampled(range(TURNS), [1]))
def test_constants_and_copies_earn_nothing(grade: Grade, tmp_path: Path, turn: int) -> None:
    """A solver that tries them for every function gets no point anywhere."""
    folder = tmp_path / "essai"
    folder.mkdir()
    stub(folder, turn)
    results = grade(folder)
    assert results["build"]["ok"]  # what does not compile earns nothing anyway
    assert {each["id"] for each in results["checks"] if each["points"]} == set()


OTHER_WAYS = {  # whether everything is always on; the bonuses that are not there
    "other_conventions": (0, {"TP2.B1", "TP2.B2"}),
    "options_ignored": (1, {"TP2.B1", "TP2.B2", "TP5.B1"}),  # its trace_ray sees no glass
}


@pytest.mark.long
@pytest.mark.parametrize(("whole", "missing"), OTHER_WAYS.values(), ids=OTHER_WAYS)
def test_other_right_ways_lose_nothing(
    grade: Grade, tmp_path: Path, whole: int, missing: set[str]
) -> None:
    """Every convention that the course accepts has every point, but for bonuses left out."""
    folder = tmp_path / "variante"
    shutil.copytree(ROOT / "reference", folder, ignore=shutil.ignore_patterns("expected", "m*s"))
    code = PROGRAM.read_text(encoding="utf-8")
    (folder / "raytracer.c").write_text(f"#define WHOLE {whole}\n{code}", encoding="utf-8")
    results = grade(folder)
    rules = manifest.load()
    lost = {rules.checks()[each].exercise for each in outcomes(results)}
    assert lost == missing
    assert results["score"] == 100


MISTAKES = {
    # The far point of the sphere.
    "        t = second; /* the first is behind: we are inside, or past it */": "return false;",
    # A picture that is as high as it is wide.
    " / half_height / theCamera.aspect": " / half_height",
    # Nothing keeps the light from behind.
    "if (n_l <= 0.f) {": "if (n_l < -2.f) {",
    # A checkerboard that doubles its cubes at zero.
    "floorf(cube.x) +": "truncf(cube.x) +",
    # A shadow from beyond the light.
    "r.tmax = vector_norm(to_light) - options.epsilon;": "",
    # The depth does not grow.
    "out->depth = in->depth + 1;": "out->depth = in->depth;",
    # No division by the sum of the indices.
    "(n1 - n2) / (n1 + n2);": "(n1 - n2);",
    # The clamp after the mean.
    "vector_clamp(trace_ray(&r), 0.f, 1.f)": "trace_ray(&r)",
}


@pytest.mark.long
def test_mistakes_lose_their_own_points(grade: Grade, tmp_path: Path) -> None:
    """One mistake in each of several functions: the checks that look at it fail, no other."""
    folder = tmp_path / "erreurs"
    shutil.copytree(ROOT / "reference", folder, ignore=shutil.ignore_patterns("expected", "m*s"))
    code = (folder / "raytracer.c").read_text(encoding="utf-8")
    for right, wrong in MISTAKES.items():
        assert code.count(right) == 1, right
        code = code.replace(right, wrong)
    (folder / "raytracer.c").write_text(code, encoding="utf-8")
    results = grade(folder)
    assert set(outcomes(results)) == {
        "tp2.camera_ray.vertical",
        "tp2.camera_ray.anywhere",
        "tp2.camera_ray.exact",
        "tp2.intersect_sphere.from_inside",
        "tp2.intersect_sphere.range",
        "tp3.shade.back",
        "tp3.checker_color.negative",
        "tp3.scene.checker_6",
        "tp4.in_shadow.beyond",
        "tp4.scene.shadows_4",
        "tp4.reflected_ray.depth",
        "tp5.reflectance.any",
        "tp5.pixel_color.clamped",
        "tp5.refracted_ray.fields",  # by the function that makes both bounced rays
    }
    messages = {each["id"]: each["message"] for each in results["checks"]}
    assert messages["tp2.intersect_sphere.from_inside"] == (
        "intersect_sphere(r = {orig (0, 0, 0), dir (0, 0, -1)}, it,"
        " obj = {SPHERE, center (0, 0, 0), radius 1}) renvoie false ; on attend true."
    )
    assert messages["tp5.reflectance.any"] == (
        "reflectance(n1 = 2, n2 = 1) renvoie 1 ; on attend 0.1111."
    )


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_a_box_that_forgets_an_axis_is_wrong(cache: Path, axis: str) -> None:
    """Objects far along that axis alone would all be put into it, and the tree never ends."""
    files = solution()
    line = "        return vector_sqnorm(vector_minus(nearest, obj->center))"
    assert files["octree.c"].count(line) == 1
    forgets = f"        nearest.{axis} = obj->center.{axis};\n"
    files["octree.c"] = files["octree.c"].replace(line, f"{forgets}{line}")
    (told,) = judge(files, cache, chosen=["tp4.octree.overlap"]).values()
    assert (told.outcome, told.points) == ("failed", 0)
