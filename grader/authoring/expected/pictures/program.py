"""A program of ours that draws: the reference, or a change of it, linked with render.c.

These sources are our own, so they run without a sandbox, and as fast as the machine goes.
"""

from __future__ import annotations

import re
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from grader.build import toolchain
from grader.checking.expected_data import Array
from grader.checking.shapes import Image
from grader.checking.student import PICTURE_SIZE
from grader.course import exercises
from grader.files import content_key
from grader.intake.header_numbers import header_number

CACHE = exercises.ROOT / "build" / "cache" / "render"
RENDERER = Path(__file__).with_name("render.c")
SECONDS = 600  # of the wall clock: a back-stop, also on a busy machine
WIDTH, HEIGHT = PICTURE_SIZE
# The C struct pixel_map of render.c.
MAP = np.dtype(
    [
        ("t", np.float32),
        ("normal", np.float32, 3),
        ("highlight", np.float32),
        ("kr", np.float32),
        ("object", np.int32),
        ("mirrored", np.int32),
        ("blocker", np.int32, 3),
        ("path", np.uint32, 4),
        ("bounces", np.int32, 2),
        ("n_l", np.float32, 3),
        ("kd", np.float32, 3),
        ("fresnel", np.float32, 3),
        ("lit", np.float32, (2, 3, 3)),
    ]
)
_OPTIONS = ("shading", "shadows", "reflections", "fresnel", "refraction", "octree")
# How every float becomes a double: types, constants, functions.
_DOUBLE = (
    (re.compile(r"\bfloat\b"), "double"),
    (re.compile(r"(?<![\w.])(\d+\.\d*(?:[eE][-+]?\d+)?|\d+[eE][-+]?\d+)f\b"), r"\1"),
    (re.compile(r"\b(sqrt|tan|cos|sin|acos|atan2|pow|floor|fmod|fabs|fmax|fmin)f\b"), r"\1"),
)


class RenderError(Exception):
    """A program cannot be built or does not draw: one line names it."""


@dataclass(frozen=True)
class Order:
    """One picture: its scene, the options that differ from the defaults, the random numbers."""

    scene: int
    options: Mapping[str, Any]
    seed: int = 0

    def line(self, maps: bool = False) -> str:
        """Return it as a line for render.c."""
        switches = [int(self.options.get(name, True)) for name in _OPTIONS]
        rest = [self.options.get("samples", 1), self.options.get("max_depth", 10)]
        rest += [self.options.get("epsilon", header_number("EPSILON")), self.seed]
        return " ".join(str(each) for each in (int(maps), self.scene, *switches, *rest))


class RenderProgram:
    """A program of the student's files with our given ones, built when it first draws.

    What draws raises RenderError.
    """

    def __init__(
        self,
        files: Mapping[str, str],
        flags: Sequence[str] = (),
        compiler: str = "",
        double: bool = False,
    ) -> None:
        given = exercises.load().given
        sources = {name: (exercises.CORE / name).read_text(encoding="utf-8") for name in given}
        sources |= files
        if double:
            sources = {name: as_double(text) for name, text in sources.items()}
        sources["render.c"] = RENDERER.read_text(encoding="utf-8")
        found = toolchain.find_compiler(compiler)
        self._command = [*found.command, "-std=gnu11", "-O2", "-ffp-contract=off", "-w", *flags]
        self._command += [f"-DWIDTH={WIDTH}", f"-DHEIGHT={HEIGHT}"]
        self._compiler, self._sources = found.version, sources
        self.id = self._digest(sorted(sources.items()))  # of the sources, and how they are compiled

    def pictures(self, orders: Sequence[Order], texels: Array) -> list[Image]:
        """Draw; each picture has shape (180, 320, 3), float32, row 0 at the bottom."""
        raw = self._run([each.line() for each in orders], texels)
        return list(np.frombuffer(raw, np.float32).reshape(-1, HEIGHT, WIDTH, 3))

    def maps(self, scene: int, texels: Array) -> Array:
        """Return what stands where in a scene, of dtype MAP, shape (180, 320)."""
        raw = self._run([Order(scene, {"octree": False}).line(maps=True)], texels)
        return np.frombuffer(raw, MAP).reshape(HEIGHT, WIDTH)

    def _run(self, lines: Sequence[str], texels: Array) -> bytes:
        path = self._built()
        with tempfile.NamedTemporaryFile(suffix=".texture") as file:
            size = np.array(texels.shape[1::-1], np.int32)
            file.write(size.tobytes() + texels.astype(np.float32).tobytes())
            file.flush()
            try:
                done = subprocess.run(
                    [path, file.name],
                    input="\n".join(lines).encode() + b"\n",
                    capture_output=True,
                    timeout=SECONDS,
                    check=False,
                )
            except subprocess.TimeoutExpired as error:
                raise RenderError(f"{path}: no end after {SECONDS} s") from error
        if done.returncode != 0:
            raise RenderError(f"{path}: status {done.returncode}: {done.stderr[:200]!r}")
        return done.stdout

    def _built(self) -> Path:
        """Compile what has not been compiled yet, and link; return the program."""
        path = CACHE / self.id
        if path.is_file():
            return path
        CACHE.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=CACHE) as name:
            folder = Path(name)
            for file, text in self._sources.items():
                (folder / file).write_text(text, encoding="utf-8")
            units = sorted(file for file in self._sources if file.endswith(".c"))
            objects = [self._object(unit, folder) for unit in units]
            _compile([*self._command, *objects, "-lm", "-o", "render"], folder)
            (folder / "render").replace(path)
        return path

    def _object(self, unit: str, folder: Path) -> str:
        """Compile one source, unless it has been with these headers."""
        headers = sorted(each for each in self._sources.items() if not each[0].endswith(".c"))
        # The program's own main gives way to the renderer's.
        command = [*self._command, *(["-Dmain=program_main"] if unit == "main.c" else [])]
        path = CACHE / f"{self._digest(headers, self._sources[unit], command)}.o"
        if not path.is_file():
            _compile([*command, "-c", unit, "-o", "made.o"], folder)
            (folder / "made.o").replace(path)
        return str(path)

    def _digest(self, *parts: object) -> str:
        return content_key(parts, self._command, self._compiler)


def as_double(text: str) -> str:
    """Return C sources with every float made a double."""
    for pattern, replacement in _DOUBLE:
        text = pattern.sub(replacement, text)
    return text


def _compile(command: Sequence[str], folder: Path) -> None:
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, timeout=SECONDS, check=False
    )
    if done.returncode != 0:
        raise RenderError(f"{' '.join(command)}: {done.stderr[:500]}")
