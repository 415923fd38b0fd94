"""The programs that the benchmarks run: the driver, POV-Ray, Tachyon; and what they print.

Seconds are CPU seconds: other programs of the machine hardly change them.
"""

from __future__ import annotations

import re
import resource
import shutil
import subprocess
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from grader.authoring.bench import scenes
from grader.build import toolchain
from grader.course.exercises import CORE, ROOT

DRIVER = Path(__file__).with_name("driver.c")
RUN_SECONDS = 300  # far beyond any of them: a back-stop
DEFINES = ("-DRAY_TMAX=1e30f", "-DSCENE_SIZE=600000")
_STUDENT = ("main.c", "raytracer.c", "octree.c")
_GIVEN = ("scene.c", "vector.c")
_POVRAY_TIME = re.compile(r"(Parse|Bounding|Trace) Time:[^\n]*\n[^\n]*with ([\d.]+) CPU-seconds")
_POVRAY_COUNT = re.compile(r"^(Rays|Shadow Ray Tests):\s+(\d+)", re.MULTILINE)
_TACHYON_TIME = re.compile(r"Preprocessing Time:\s+([\d.]+) seconds")

Phase = Literal["render", "build"]


class BenchError(Exception):
    """A program failed: one line that names it."""


@dataclass(frozen=True)
class Run:
    """What a program printed, and its CPU seconds."""

    text: str
    seconds: float


@dataclass(frozen=True)
class Cost:
    """CPU seconds of drawing and of what comes before; all the rays, where the program says."""

    render: float
    build: float
    rays: int = 0

    def seconds(self, phase: Phase) -> float:
        """Return one of the two."""
        return self.render if phase == "render" else self.build


def run(command: Sequence[str | Path], folder: Path) -> Run:
    """Run a program in a folder. Raises BenchError when it fails."""
    before = _children_seconds()
    name = Path(command[0]).name
    try:
        done = subprocess.run(
            command,
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            timeout=RUN_SECONDS,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise BenchError(f"{name}: cannot be run: {error}") from error
    if done.returncode != 0:
        raise BenchError(f"{name}: exit status {done.returncode}: {done.stdout[-1500:].strip()}")
    return Run(done.stdout, _children_seconds() - before)


def _children_seconds() -> float:
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def build_driver(folder: Path, name: str, size: tuple[int, int], *, counting: bool = False) -> Path:
    """Build the reference solution with the driver as a program; one that counts, if asked."""
    compiler = toolchain.find_compiler()
    flags = ["-std=gnu11", "-O3", f"-DWIDTH={size[0]}", f"-DHEIGHT={size[1]}", *DEFINES]
    flags += [f"-I{ROOT / 'reference'}", f"-I{CORE}"]
    parts = folder / f"{name}.parts"
    parts.mkdir(parents=True, exist_ok=True)
    sources = [ROOT / "reference" / each for each in _STUDENT]
    sources += [CORE / each for each in _GIVEN] + [DRIVER]
    objects = [parts / f"{source.stem}.o" for source in sources]
    for source, made in zip(sources, objects, strict=True):
        own = _own_flags(source, counting, compiler.is_clang)
        run([*compiler.command, *flags, *own, "-c", source, "-o", made], ROOT)
    program = folder / name
    run([*compiler.command, *objects, "-lm", "-o", program], ROOT)
    return program


def _own_flags(source: Path, counting: bool, clang: bool) -> list[str]:
    """Return the flags of one file of the driver's program; driver.c says what they are for."""
    if source == DRIVER:
        return ["-DBENCH_COUNT"] if counting else []
    flags = {
        "main.c": ["-Dmain=mrt_program_main"],
        "scene.c": ["-Dmirror_color=bench_mirror_color"],
    }.get(source.name, [])
    if not counting:
        return flags
    if source.name == "octree.c":
        flags = ["-Dmalloc=bench_malloc", "-Dfree=bench_free"]
    # The tiny functions of the headers would only slow it down; clang cannot leave them out.
    leave_out = [] if clang else ["-finstrument-functions-exclude-file-list=vector.h,ray.h"]
    return [*flags, "-finstrument-functions", *leave_out]


def parse_numbers(text: str) -> dict[str, list[float]]:
    """Read the driver's lines "word number": all the numbers of each word, in order."""
    numbers: dict[str, list[float]] = {}
    for line in text.splitlines():
        word, value = line.split()
        numbers.setdefault(word, []).append(float(value))
    return numbers


def list_scene(driver: Path, name: str) -> scenes.BenchScene:
    """Return a scene as the driver builds it."""
    return scenes.parse(run([driver, name, "--list"], driver.parent).text.splitlines())


def draw_ours(driver: Path, name: str) -> Cost:
    """Draw a scene with our program."""
    numbers = parse_numbers(run([driver, name], driver.parent).text)
    return Cost(numbers["render_seconds"][0], numbers["build_seconds"][0])


def draw_povray(file: Path, size: tuple[int, int]) -> Cost:
    """Draw a file with POV-Ray, by one thread and without anti-aliasing."""
    options = [f"+W{size[0]}", f"+H{size[1]}", "-A", "-D", "-V", "+WT1", "+FP", "+Opovray.ppm"]
    return parse_povray(run(["povray", f"+I{file.name}", *options], file.parent).text)


def parse_povray(text: str) -> Cost:
    """Read POV-Ray's statistics. Raises BenchError when they are not there."""
    seconds = {name: float(value) for name, value in _POVRAY_TIME.findall(text)}
    counts = {name: int(value) for name, value in _POVRAY_COUNT.findall(text)}
    try:
        rays = counts["Rays"] + counts["Shadow Ray Tests"]
        return Cost(seconds["Trace"], seconds["Parse"] + seconds["Bounding"], rays)
    except KeyError as error:
        raise BenchError(f"povray: no {error} in its statistics") from None


def draw_tachyon(file: Path, size: tuple[int, int]) -> Cost:
    """Draw a file with Tachyon, by one thread.

    It says no CPU seconds: drawing is what a whole picture takes more than one of 16 x 9 pixels.
    """
    tiny, whole = (_tachyon(file, each) for each in ((16, 9), size))
    found = _TACHYON_TIME.search(whole.text)
    if found is None:
        raise BenchError("tachyon: no preprocessing time in what it printed")
    return Cost(whole.seconds - tiny.seconds, float(found[1]))


def _tachyon(file: Path, size: tuple[int, int]) -> Run:
    options = ["-res", str(size[0]), str(size[1]), "-numthreads", "1", "-format", "PPM"]
    return run(["tachyon", file.name, *options, "-o", "tachyon.ppm"], file.parent)


def installed(names: Iterable[str]) -> list[str]:
    """Return which of these programs the machine has."""
    return [name for name in names if shutil.which(name)]
