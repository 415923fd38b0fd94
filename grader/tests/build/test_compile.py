"""The skeleton and the solution compile without a word, everywhere; the skeleton runs every scene.

Both are built in a copy of core_c/, the solution with the reference's files put over it: what a
student has, in a folder with a space and an accent.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

import pytest

from grader.course.exercises import CORE, ROOT, load

HEADERS = tuple(name for name in (*load().given, *load().student) if name.endswith(".h"))
REFERENCE = ROOT / "reference"
PROGRAM = ("vector.c", "scene.c", "main.c", "octree.c", "raytracer.c")
HANDOUT = ("-g", "-O3", *PROGRAM, "-lm", "-o", "mrt")
CAREFUL = ("-Wall", "-Wextra", "-Wshadow", "-Werror")
STRICT = ("-std=gnu11", *CAREFUL, "-Wpedantic", "-Wconversion", "-Wstrict-prototypes")
SANITIZED = ("-std=gnu11", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
HEADER = b"P6\n160 90\n255\n"
COMPILERS = ("gcc", "clang")


def run(command: Sequence[str], folder: Path) -> subprocess.CompletedProcess[str]:
    """Run a command in a folder, at most a minute, in English, and return what it said."""
    return subprocess.run(
        command,
        cwd=folder,
        env={**os.environ, "LC_ALL": "C", "MRT_LANG": "en"},
        capture_output=True,
        text=True,
        errors="replace",
        timeout=60,
        check=False,
    )


def need(found: bool, what: str) -> None:
    """Skip the test when a tool is missing; on the CI's machine, where it must be there, fail."""
    assert found or "MRT_CI" not in os.environ, f"{what} is not installed"
    if not found:
        pytest.skip(f"{what} is not installed")


def compile_silently(command: Sequence[str], folder: Path) -> None:
    """Hold that a compiler succeeds without a word."""
    need(shutil.which(command[0]) is not None, command[0])
    done = run(command, folder)
    assert (done.stdout + done.stderr, done.returncode) == ("", 0)


def copy_sources(folder: Path, *origins: Path) -> None:
    """Copy what the program is built and run from, the later origins over the earlier."""
    for origin in origins:
        for path in sorted(origin.iterdir()):
            if path.suffix in {".c", ".h", ".ppm"} and path.is_file():
                shutil.copy(path, folder)


@pytest.fixture(scope="module", params=["skeleton", "solution"])
def sources(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with all the sources of the skeleton, then of the solution."""
    folder = tmp_path_factory.mktemp(f"été {request.param}")
    copy_sources(folder, *([CORE] if request.param == "skeleton" else [CORE, REFERENCE]))
    return folder


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("options", [(), ("-O2", "-fopenmp", "-DWIDTH=96", "-DHEIGHT=64")])
def test_every_source_is_silent_as_c(
    sources: Path, compiler: str, options: tuple[str, ...]
) -> None:
    """Every .c file compiles at the strictest warnings, plain, and optimised with threads."""
    files = sorted(path.name for path in sources.glob("*.c"))
    assert set(PROGRAM) <= set(files)
    compile_silently([compiler, *STRICT, *options, "-c", *files], sources)


def test_the_png_writer_is_silent(sources: Path) -> None:
    """With libpng, as `make mrt` builds it, main.c compiles at the strictest warnings too."""
    need(shutil.which("pkg-config") is not None, "pkg-config")
    found = run(["pkg-config", "--cflags", "libpng"], sources)
    need(found.returncode == 0, "libpng")
    options = ["-DMRT_PNG", *found.stdout.split()]
    compile_silently(["gcc", *STRICT, *options, "-c", "main.c"], sources)


def test_the_handouts_line_is_silent(sources: Path) -> None:
    """The handout's own g++ line builds ./mrt without a word, even with the warnings on."""
    compile_silently(["g++", *HANDOUT, "-Wall", "-Wextra", "-Werror"], sources)
    assert (sources / "mrt").is_file()


@pytest.mark.parametrize("path", [*(CORE / name for name in HEADERS), REFERENCE / "raytracer.h"])
def test_header_stands_alone(tmp_path: Path, path: Path) -> None:
    """A header included first, twice, compiles as C with both compilers and as C++."""
    include = f'#include "{path.name}"\n'
    (tmp_path / "probe").write_text(include * 2, encoding="ascii")
    folders = ["-I", str(path.parent), "-I", str(CORE)]
    for compiler in COMPILERS:
        command = [compiler, *STRICT, *folders, "-fsyntax-only", "-x", "c", "probe"]
        compile_silently(command, tmp_path)
    # No -Wpedantic here: C++ has no anonymous structures, which the objects' union needs.
    for compiler in ("g++", "clang++"):
        command = [compiler, *CAREFUL, *folders, "-fsyntax-only", "-x", "c++", "probe"]
        compile_silently(command, tmp_path)


def test_every_header_is_tried() -> None:
    """The headers of the manifest are those that core_c/ holds."""
    assert sorted(HEADERS) == sorted(path.name for path in CORE.glob("*.h"))


def test_the_skeleton_runs_every_scene(tmp_path: Path) -> None:
    """Every scene number writes a picture under the sanitizers; the next number is refused."""
    copy_sources(tmp_path, CORE)
    size = ["-DWIDTH=160", "-DHEIGHT=90"]
    compile_silently(["gcc", *SANITIZED, *size, *PROGRAM, "-lm", "-o", "mrt"], tmp_path)
    number = 0
    while (done := run(["./mrt", str(number), f"picture{number}"], tmp_path)).returncode == 0:
        picture = (tmp_path / f"picture{number}.ppm").read_bytes()
        assert picture.startswith(HEADER)
        assert len(picture) == len(HEADER) + 3 * 160 * 90
        number += 1
        assert number < 100
    assert number >= 10
    assert done.returncode == 2
    assert done.stderr.startswith("mrt: unknown scene")
