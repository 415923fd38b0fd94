"""The hostile programs as submissions, and what must come of each."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from grader.authoring.specimens.student import STUDENT_MAIN, main_c
from grader.course.exercises import ROOT
from grader.execution.records import Cause
from grader.execution.worker_process import Limits
from grader.intake.originals import REFERENCE

FOLDER = REFERENCE / "hostile"
SECRET_TEXT = "the-secret-of-the-grader-0451"
MARK = "mrt-hostile-mark"  # in the name of whatever a program tries to leave

_ATTACK = re.compile(r"^ATTACK\((\w+)\)", re.MULTILINE)
INCLUDE = '#include "raytracer.h"\n'

# How the programs that do not come back must end, by cause; all the others come back, refused.
_ENDS = {
    (Cause.SIGNAL,): (
        "abort_at_once divide_by_zero endless_recursion fake_report far_outside"
        " illegal_instruction null_pointer old_gate one_past spoil_trace"
    ),
    (Cause.TIMEOUT,): "endless_loop endless_loop_deaf",
    (Cause.WAITING,): "sleep_deaf sleep_for_ever stop_itself",
    (Cause.EXIT,): (
        "close_everything exit_0 exit_at_once fool_terminal leave_on_fault"
        " lie_in_trace rewrite_interpreter"
    ),
    (Cause.EXIT, Cause.TIMEOUT, Cause.WAITING): "drip_answer flood_answer steal_requests",
    (Cause.EXIT, Cause.SIGNAL): "unmap_everything",
    # The worker's own next step fails for want of memory, in one way or another.
    (Cause.EXIT, Cause.MEMORY, Cause.SIGNAL, Cause.TIMEOUT): "take_all_memory",
    (Cause.MEMORY,): "forge_memory",
    (Cause.KILLED,): "die_by_kill",
}
_FORGED = {Cause.EXIT}  # for every other forge_*


@dataclass(frozen=True)
class Quick(Limits):
    """Short limits: what hangs on purpose need not hang long."""

    cpu: float = 1.0

    @property
    def wall(self) -> float:
        """Seconds of waiting for one answer."""
        return 1.5


def attacks() -> list[str]:
    """Return the names of the programs, in the order in which `attack` numbers them."""
    return [name for path in _sources() for name in _ATTACK.findall(path.read_text("utf-8"))]


def ends_of(name: str) -> set[Cause]:
    """Return how a program must end; empty when it must come back, refused."""
    for causes, names in _ENDS.items():
        if name in names.split():
            return set(causes)
    return _FORGED if name.startswith("forge_") else set()


def write(folder: Path, secret: Path, grader: int) -> Path:
    """Write all the programs as one submission: fill_circle of radius k runs number k."""
    names = attacks()
    files = {path.name: path.read_text(encoding="utf-8") for path in _sources()}
    files["hostile.h"] = (FOLDER / "run" / "hostile.h").read_text(encoding="utf-8")
    files["target.h"] = (
        f'#define SECRET "{secret}"\n#define MARK "{MARK}"\n'
        f'#define ROOT "{ROOT}"\n#define PARENT {grader}\n'
    )
    declared = "".join(f"void attack_{name}(color *img);\n" for name in names)
    table = ", ".join(f"attack_{name}" for name in names)
    files["dispatch.c"] = (
        f"{INCLUDE}void attack(int k, color *img);\n{declared}"
        f"void attack(int k, color *img) {{ void (*all[])(color *) = {{ {table} }}; all[k](img); }}"
    )
    body = "extern void attack(int, color *); attack((int)radius, img); (void)center; (void)c;"
    return lay(folder, {"main.c": main_c({**STUDENT_MAIN, "fill_circle": body}), **files})


def lay(folder: Path, files: dict[str, str]) -> Path:
    """Write a submission: these files, and a student's own for the rest."""
    folder.mkdir(parents=True, exist_ok=True)
    content = {"main.c": main_c(STUDENT_MAIN), "raytracer.h": '#include "exercises.h"\n'}
    content |= {"raytracer.c": INCLUDE, "octree.c": INCLUDE, **files}
    for name, text in content.items():
        (folder / name).write_text(text, encoding="utf-8", errors="surrogateescape")
    return folder


OVERRULED = ("lie_about_constants",)  # what they define is the shim's: no more comes of it


def loads() -> Iterator[tuple[str, str]]:
    """Yield programs that act as soon as they are loaded: name, and C file."""
    for path in sorted((FOLDER / "load").glob("*.c")):
        yield path.stem, path.read_text(encoding="utf-8")


def compilations(secret: Path) -> Iterator[tuple[str, str]]:
    """Yield sources against the compiler: name, and C file with the secret's path in it."""
    for path in sorted((FOLDER / "compile").glob("*.c")):
        yield path.stem, path.read_text(encoding="utf-8").replace("@SECRET@", str(secret))


def _sources() -> list[Path]:
    return sorted((FOLDER / "run").glob("*.c"))
