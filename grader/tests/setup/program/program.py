"""Builds the program and runs it, for the tests that try to break it."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path

from grader.course.exercises import ROOT
from grader.intake.header_numbers import header_number
from grader.tests.build.test_compile import PROGRAM, SANITIZED, copy_sources, need
from grader.tests.support import sources

REFERENCE = ROOT / "reference"
HERE = Path(__file__).parent
# A number too big for an integer is not among UBSan's usual checks.
WATCHED = (*SANITIZED, "-fsanitize=float-cast-overflow", "-fno-omit-frame-pointer", "-O1")
SCENES = range(int(header_number("FIRST_RAYTRACED_SCENE")) + len(sources.scenes()))
WIDTH, HEIGHT = 64, 36

Done = subprocess.CompletedProcess[str]


def run(command: Sequence[object], folder: Path, settings: Mapping[str, str] | None = None) -> Done:
    """Run a command in a folder; its messages are in English unless asked."""
    # Leaks are valgrind's part: AddressSanitizer's own search does not run in every container.
    usual = {"LC_ALL": "C", "MRT_LANG": "en", "ASAN_OPTIONS": "detect_leaks=0"}
    return subprocess.run(
        [str(word) for word in command],
        cwd=folder,
        env={**os.environ, **usual, **(settings or {})},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        encoding="utf-8",
        errors="replace",
        timeout=300,  # a back-stop, on a busy machine too
        check=False,
    )


def build(output: Path, flags: Sequence[str], files: Sequence[object], folder: Path) -> Path:
    """Compile a program with gcc; return its path."""
    need(shutil.which("gcc") is not None, "gcc")
    command = ["gcc", "-std=gnu11", *flags, *files, "-lm", "-o", output]
    done = run(command, folder)
    assert (done.stdout + done.stderr, done.returncode) == ("", 0)
    return output


def need_sanitizers(folder: Path) -> None:
    """Skip the test where gcc has no sanitizers, or they do not start."""
    need(shutil.which("gcc") is not None, "gcc")
    (folder / "probe.c").write_text("int main(void) { return 0; }\n", encoding="ascii")
    built = run(["gcc", *WATCHED, "probe.c", "-o", "probe"], folder)
    need(built.returncode == 0 and run(["./probe"], folder).returncode == 0, "gcc's sanitizers")


def need_libpng(folder: Path) -> None:
    """Skip the test where `make mrt` finds no libpng."""
    need(shutil.which("pkg-config") is not None, "pkg-config")
    need(run(["pkg-config", "--exists", "libpng"], folder).returncode == 0, "libpng")


def build_mrt(folder: Path, flags: Sequence[str], *origins: Path) -> Path:
    """Build ./mrt in a new folder, from the sources of the given folders."""
    folder.mkdir()
    copy_sources(folder, *origins)
    return build(folder / "mrt", flags, PROGRAM, folder)


def size_flags(width: int, height: int) -> tuple[str, str]:
    """Return the flags that set the picture's size."""
    return f"-DWIDTH={width}", f"-DHEIGHT={height}"


def make_mrt(folder: Path, source: str, **settings: str) -> Path:
    """Build the program as `make mrt` does, outside the checkout; return its path."""
    done = run(
        ["sh", "grader/setup/program.sh", "mrt"],
        ROOT,
        {"SRC": source, "BUILD": str(folder), "CC": "cc", **settings},
    )
    assert (done.stderr, done.returncode) == ("", 0)
    return folder / source / "mrt"


def read_ppm(path: Path) -> tuple[int, int, bytes]:
    """Return width, height and pixels of a PPM as the program writes it."""
    magic, size, levels, pixels = path.read_bytes().split(b"\n", 3)
    width, height = map(int, size.split())
    assert (magic, levels, len(pixels)) == (b"P6", b"255", 3 * width * height)
    return width, height, pixels


def listing(folder: Path) -> dict[str, bytes]:
    """Return the files of a folder, with what is in them."""
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def assert_refused(done: Done, *parts: str) -> None:
    """Hold that the program ended with status 2 and one line on stderr that has these parts."""
    assert done.stderr.startswith("mrt: ")
    assert done.stderr.count("\n") == 1
    assert done.stderr.endswith("\n")
    assert [part for part in parts if part not in done.stderr] == []
    assert (done.stdout, done.returncode) == ("", 2)
