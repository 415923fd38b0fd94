"""./mrt itself: TP1's pictures at their full size to the pixel, threads, and printing."""

from __future__ import annotations

import os
import pty
import signal
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from grader.build.toolchain import find_compiler
from grader.course.exercises import CORE, ROOT, load
from grader.tests.core.oracles import Array
from grader.tests.support.terminals import read_all

WIDTH, HEIGHT = 1280, 720
SOURCES = ("vector.c", "scene.c", "main.c", "octree.c", "raytracer.c")
# Draws scenes and writes their pixels, as floats, to stdout.
DRIVER = r"""
#undef main
#include "exercises.h"
#include <stdio.h>
int main(void) {
    const int scenes[] = {0, 2, 7, 10};
    options.samples = 2;
    for (int k = 0; k < 4; k++) {
        setup_scene(scenes[k]);
        raytrace();
        fwrite(output_image, sizeof output_image, 1, stdout);
    }
    return 0;
}
"""
# Draws half of the rows, and calls the timer itself, so that no clock has a say.
HALF = r"""
#undef main
#undef raytrace
#include "utils.h"
void raytrace(void) {
    for (int k = 0; k < WIDTH * (HEIGHT / 2); k++) {
        output_image[k] = vector_init(0.f, 0.f, 0.f);
    }
    raise(SIGALRM);
}
int main(void) {
    mrt_raytrace();
    return mrt_save_picture("half", output_image);
}
"""
PRINTER = r"""
#include "vector.h"
int main(void) {
    vector_print(vector_init(1.f, -2.5f, 1e10f));
    return 0;
}
"""


def run(command: Sequence[str | Path], folder: Path) -> bytes:
    """Run a command that must succeed; return its stdout."""
    environment = {**os.environ, "OMP_NUM_THREADS": "4"}
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, timeout=60, check=False
    )
    assert (done.returncode, done.stderr) == (0, b"")
    return done.stdout


def compile_program(folder: Path, program: str, *arguments: str) -> Path:
    """Compile files of the reference, and flags, in a folder; return the program's path."""
    for origin in (CORE, ROOT / "reference"):
        for name in (*load().given, *load().student):
            if (origin / name).is_file():
                (folder / name).write_bytes((origin / name).read_bytes())
    command = [*find_compiler().command, "-std=gnu11", "-O1", *arguments, "-lm"]
    run([*command, "-o", program], folder)
    return folder / program


@pytest.fixture(scope="module")
def draw(tmp_path_factory: pytest.TempPathFactory) -> Callable[[int], Array]:
    """Return a function that runs ./mrt SCENE and reads its picture, row 0 at the bottom."""
    folder = tmp_path_factory.mktemp("mrt")
    program = compile_program(folder, "mrt", *SOURCES)

    def picture(scene: int) -> Array:
        run([program, str(scene), "picture"], folder)
        data = (folder / "picture.ppm").read_bytes()
        header = b"P6\n%d %d\n255\n" % (WIDTH, HEIGHT)
        assert data.startswith(header)
        rows = np.frombuffer(data, np.uint8, offset=len(header)).reshape(HEIGHT, WIDTH, 3)
        return rows[::-1].astype(int)

    return picture


def to_bytes(color: Sequence[float]) -> Array:
    """Return the bytes of a colour: clamped, times 255, truncated."""
    return np.asarray(np.clip(np.asarray(color, np.float32), 0, 1) * 255, int)


def gradient(c1: Sequence[float], c2: Sequence[float]) -> Array:
    """Return the gradient's bytes for each row, shape (HEIGHT, 3)."""
    share = np.arange(HEIGHT)[:, None] / HEIGHT
    return np.floor((share * c1 + (1 - share) * c2) * 255).astype(int)


def test_mrt_0_is_red(draw: Callable[[int], Array]) -> None:
    """Every pixel."""
    np.testing.assert_array_equal(draw(0), np.broadcast_to((255, 0, 0), (HEIGHT, WIDTH, 3)))


def test_mrt_1_is_a_rectangle_on_a_ground(draw: Callable[[int], Array]) -> None:
    """Every pixel, both corners included: columns W/4 to W/3, rows H/5 to H/4."""
    want = np.empty((HEIGHT, WIDTH, 3), int)
    want[:] = to_bytes((0.7, 0.3, 0.1))
    want[144:181, 320:427] = to_bytes((0.2, 0.6, 0.7))
    np.testing.assert_array_equal(draw(1), want)


def test_mrt_2_is_a_gradient(draw: Callable[[int], Array]) -> None:
    """Blue at the top, white at the bottom, each row within one level."""
    got = draw(2)
    np.testing.assert_array_equal(got, np.broadcast_to(got[:, :1], got.shape))
    assert np.abs(got[:, 0] - gradient((0, 0, 1), (1, 1, 1))).max() <= 1


def test_mrt_3_is_a_landscape(draw: Callable[[int], Array]) -> None:
    """Gradient, sun and grass: sun and grass exactly, the sky within one level."""
    got = draw(3)
    j, i = np.indices((HEIGHT, WIDTH))
    sun = (i - 1024) ** 2 + (j - 576) ** 2 < 64**2
    grass = j <= HEIGHT // 4
    np.testing.assert_array_equal(got[sun], np.broadcast_to((255, 255, 0), (sun.sum(), 3)))
    green = np.broadcast_to(to_bytes((0.1, 0.8, 0.4)), (grass.sum(), 3))
    np.testing.assert_array_equal(got[grass], green)
    want = np.broadcast_to(gradient((0, 0, 1), (1, 1, 1))[:, None], got.shape)
    sky = ~sun & ~grass
    assert np.abs(got[sky] - want[sky]).max() <= 1


def test_threads_draw_the_same_picture(tmp_path: Path) -> None:
    """With OpenMP on four threads and without, every float is the same, glass and samples too."""
    (tmp_path / "driver.c").write_text(DRIVER, encoding="ascii")
    size = ["driver.c", *SOURCES, "-Dmain=program_main", "-DWIDTH=160", "-DHEIGHT=90"]
    probe = [*find_compiler().command, "-fopenmp", "-x", "c", os.devnull, "-shared", "-o", "probe"]
    found = subprocess.run(probe, cwd=tmp_path, capture_output=True, timeout=60, check=False)
    # clang's OpenMP is a package of its own; gcc brings it, so there nothing may be skipped.
    assert found.returncode == 0 or find_compiler().is_clang
    if found.returncode != 0:
        pytest.skip("the compiler has no OpenMP")
    alone = run([compile_program(tmp_path, "alone", *size)], tmp_path)
    threads = run([compile_program(tmp_path, "threads", *size, "-fopenmp")], tmp_path)
    assert len(alone) == 4 * 160 * 90 * 12
    assert threads == alone


@pytest.fixture(scope="module")
def half(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a program whose raytrace stops half-way to show how far it is."""
    folder = tmp_path_factory.mktemp("half")
    (folder / "driver.c").write_text(HALF, encoding="ascii")
    size = ["-Dmain=program_main", "-Draytrace=other_raytrace", "-DWIDTH=64", "-DHEIGHT=36"]
    return compile_program(folder, "half", "driver.c", *SOURCES, *size)


def test_progress_is_shown_at_a_terminal(half: Path) -> None:
    """And wiped away in the end; what is not drawn is black all the same."""
    reading, writing = pty.openpty()
    done = subprocess.run(
        [half], cwd=half.parent, stdout=subprocess.PIPE, stderr=writing, timeout=60, check=True
    )
    os.close(writing)
    assert read_all(reading) == b"\r 50 %\r     \r"
    assert done.stdout == b"half.ppm : 64 x 36\n"
    assert set((half.parent / "half.ppm").read_bytes()[len(b"P6\n64 36\n255\n") :]) == {0}


def test_no_progress_where_nobody_looks(half: Path) -> None:
    """In a pipe or a file there is nothing but the picture's name, and no timer is set."""
    done = subprocess.run([half], cwd=half.parent, capture_output=True, timeout=60, check=False)
    assert (done.stdout, done.stderr) == (b"", b"")
    assert done.returncode == -signal.SIGALRM


def test_vector_print(tmp_path: Path) -> None:
    """One line, as its contract says."""
    (tmp_path / "printer.c").write_text(PRINTER, encoding="ascii")
    program = compile_program(tmp_path, "printer", "printer.c", "vector.c")
    assert run([program], tmp_path) == b"(1, -2.5, 1e+10)\n"
