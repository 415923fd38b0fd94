"""No program reads or writes where it must not: sanitizers, valgrind, and made-up inputs."""

from __future__ import annotations

import os
import re
import shutil
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from grader.course.exercises import CORE
from grader.tests.build.test_compile import copy_sources, need
from grader.tests.setup.program.program import (
    HERE,
    REFERENCE,
    SCENES,
    WATCHED,
    Done,
    build,
    build_mrt,
    need_sanitizers,
    read_ppm,
    run,
    size_flags,
)
from grader.tests.support.sampling import sampled

VALGRIND = (
    "valgrind",
    "--quiet",
    "--error-exitcode=99",
    "--leak-check=full",
    "--errors-for-leak-kinds=definite,possible",
)
STAGES = (
    "--no-shading",
    "--no-shadows",
    "--no-reflections",
    "--no-fresnel",
    "--no-refraction",
    "--no-octree",
    "--samples=2",
    "--max-depth=0",
    "--max-depth=1000",
    "--epsilon=0",
    "--epsilon=1000",
)
# Cylinder and cone, checkerboard and texture, glass. Few objects: one option leaves the octree out.
EXTENSIONS = (10, 11, 12)
FUZZ_OPTIONS = {  # a header may ask for 200 MB: let that fail too
    "ASAN_OPTIONS": "detect_leaks=0:allocator_may_return_null=1:max_allocation_size_mb=8"
}


def draw_every_scene(mrt: Path, folder: Path, size: tuple[int, int]) -> None:
    """Hold that a program draws every scene without a complaint."""
    for k in SCENES:
        done = run([mrt, k, f"picture{k}"], folder)
        assert (k, done.stderr, done.returncode) == (k, "", 0)
        assert done.stdout.startswith(f"picture{k}.ppm")  # what it has written
        assert read_ppm(folder / f"picture{k}.ppm")[:2] == size


@pytest.mark.long
def test_every_scene_under_the_sanitizers(watched_mrt: Path, tmp_path: Path) -> None:
    """AddressSanitizer and UBSan report nothing on any scene at 160x90; the next is unknown."""
    draw_every_scene(watched_mrt, tmp_path, (160, 90))
    assert run([watched_mrt, len(SCENES), "none"], tmp_path).returncode == 2


@pytest.mark.parametrize("stage", STAGES)
def test_every_option_under_the_sanitizers(watched_mrt: Path, tmp_path: Path, stage: str) -> None:
    """Each option draws the scenes with every kind of object and material, without a report."""
    for k in EXTENSIONS:
        done = run([watched_mrt, k, tmp_path / "picture", *stage.split("=")], tmp_path)
        assert (k, done.stderr, done.returncode) == (k, "", 0)
        assert read_ppm(tmp_path / "picture.ppm")[:2] == (160, 90)


@pytest.mark.long
@pytest.mark.parametrize("size", [(1, 1), (1, 7)])
def test_odd_sizes_under_the_sanitizers(tmp_path: Path, size: tuple[int, int]) -> None:
    """A picture of one row, one column or one pixel works for every scene."""
    need_sanitizers(tmp_path)
    mrt = build_mrt(tmp_path / "mrt", [*WATCHED, *size_flags(*size)], CORE, REFERENCE)
    draw_every_scene(mrt, tmp_path, size)


@pytest.mark.long
@pytest.mark.parametrize("program", sampled(["solution", "skeleton"], ["skeleton"]))
def test_every_scene_under_valgrind(tmp_path: Path, program: str) -> None:
    """Valgrind finds no invalid access, no use of an unset value and no leak, at 160x90."""
    need(shutil.which("valgrind") is not None, "valgrind")
    copy_sources(tmp_path, *([CORE, REFERENCE] if program == "solution" else [CORE]))
    flags = ["-O1", "-g", *size_flags(160, 90), f"-I{tmp_path}"]
    files = [HERE / "scenes.c", "raytracer.c", "octree.c", "scene.c"]
    scenes = build(tmp_path / "scenes", flags, files, tmp_path)
    with ThreadPoolExecutor(2) as pool:
        commands = [[*VALGRIND, scenes, *SCENES[k::4]] for k in range(4)]
        runs = list(pool.map(lambda command: run(command, tmp_path), commands))
    said = [line for done in runs for line in done.stderr.splitlines()]
    to_do = [] if program == "solution" else ["Still to write:"] * len(SCENES)
    assert [line[:15] for line in said] == to_do, "\n".join(said)
    assert [done.returncode for done in runs] == [0] * len(runs)
    assert {read_ppm(path)[:2] for path in tmp_path.glob("picture*.ppm")} == {(160, 90)}
    assert len(list(tmp_path.glob("picture*.ppm"))) == len(SCENES)


@pytest.mark.long
def test_tp1_at_its_edges(tmp_path: Path) -> None:
    """Huge, negative, infinite and NaN coordinates, radii and colours: no report, no stray ink."""
    need_sanitizers(tmp_path)
    flags = [*WATCHED, *size_flags(9, 5), f"-I{REFERENCE}", f"-I{CORE}"]
    rest = [REFERENCE / "raytracer.c", REFERENCE / "octree.c", CORE / "scene.c"]
    edges = build(tmp_path / "edges", flags, [HERE / "edges.c", *rest], tmp_path)
    done = run([edges], tmp_path)
    assert (done.stderr, done.returncode) == ("", 0), done.stdout
    assert done.stdout == f"{16**4 + 16**3 + 4 * 16**2} calls\n"


def fuzz_folder(tmp_path: Path) -> Path:
    """Return a folder for the driver: "folder.ppm" can be neither replaced nor removed."""
    folder = tmp_path / "here"
    (folder / "folder.ppm" / "full").mkdir(parents=True)
    (folder / "folder").mkdir()
    return folder


def counts(done: Done) -> tuple[int, ...]:
    """Return the numbers of the driver's last line: cases, pictures read, commands done."""
    assert done.returncode == 0, done.stdout + done.stderr[:3000]
    last = done.stdout.splitlines()[-1]  # after what was written
    return tuple(map(int, re.findall(r"[0-9]+", last)))


@pytest.mark.long
def test_made_up_inputs(tmp_path: Path) -> None:
    """100,000 made-up pictures and command lines: no report, and every rule of fuzz.c holds."""
    need_sanitizers(tmp_path)
    flags = [*WATCHED, *size_flags(8, 8), "-DSCENE_SIZE=4", f"-I{CORE}"]
    fuzz = build(tmp_path / "fuzz", flags, [HERE / "fuzz.c"], tmp_path)
    folder = fuzz_folder(tmp_path)
    cases, pictures, commands = counts(run([fuzz, 1, 100_000], folder, FUZZ_OPTIONS))
    assert cases == 100_000
    assert pictures > 2_000
    assert commands > 5_000
    assert sorted(os.listdir(folder)) == ["folder", "folder.ppm"]


def test_made_up_inputs_under_valgrind(tmp_path: Path) -> None:
    """A few more under valgrind, which sees unset values and leaks."""
    need(shutil.which("valgrind") is not None, "valgrind")
    flags = ["-O1", "-g", *size_flags(8, 8), "-DSCENE_SIZE=4", f"-I{CORE}"]
    fuzz = build(tmp_path / "fuzz", flags, [HERE / "fuzz.c"], tmp_path)
    done = run([*VALGRIND, fuzz, 2, 2_000], fuzz_folder(tmp_path))
    assert counts(done)[0] == 2_000
    assert done.stderr == ""
