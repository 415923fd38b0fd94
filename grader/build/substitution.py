"""A submission's library in which functions of the reference stand in the place of its own.

Every object is compiled so that a function can be replaced when the library is linked: of several
definitions of a name the one that is not weak counts, and else the first. So the submission's
functions that are replaced are made weak, as are the reference's others. Static functions stay each
side's own, and global variables are the submission's.

What the check judges must be the submission's own: the reference's version of it is weak, a trap
stands before it should the submission have none, and the linker leaves out what nobody can call.
"""

from __future__ import annotations

import shutil
from collections.abc import Collection
from dataclasses import replace
from functools import cache

from grader.build.builder import Built
from grader.build.records import BuildResult
from grader.build.target import ObjectFile
from grader.course import exercises as manifest
from grader.intake import originals
from grader.intake.records import Submission
from grader.intake.submission import SHIM

TRAPS = "mrt_traps.c"
PROBE = manifest.PACKAGE / "build" / "shim" / "probe.c"
PROBED = "trace_ray"  # what it stands in for
_TRAP = "__attribute__((weak)) void {name}(void) {{ __builtin_trap(); }}\n"


def is_possible() -> bool:
    """Say whether the reference is here, and the tool that changes objects."""
    return originals.has_solution() and has_tool()


def has_tool() -> bool:
    """Say whether the tool that changes objects is here."""
    return shutil.which("objcopy") is not None


@cache
def reference() -> Submission:
    """Return the reference as a submission. Raises OSError."""
    files = {name: (originals.REFERENCE / name).read_bytes() for name in manifest.load().student}
    return Submission("reference", files, missing=())


def substituted(built: Built, solution: Built, names: Collection[str]) -> BuildResult:
    """Return the submission's library with these functions of the reference in place of its own.

    Raises MixError when it cannot be linked, BuildError by the machine's fault.
    """
    job = built.job
    exercises = manifest.load().exercises
    known = {name for each in exercises for name in each.functions}
    replaced, kept = sorted(known & set(names)), sorted(known - set(names))
    theirs = _weakened(built, replaced)
    traps = job.compile_text(TRAPS, "".join(_TRAP.format(name=each) for each in kept))
    ours = []
    for name in sorted({each.file for each in exercises if {*each.functions} & {*replaced}}):
        weak = sorted(solution.symbols[name].defined - {*replaced})
        ours.append((f"reference/{name}", job.weakened(solution.objects[name], weak)))
    # The submission's first: of its own several definitions, as of the traps, the first counts.
    parts = [(SHIM, built.shim), *{**built.objects, **theirs}.items(), (TRAPS, traps), *ours]
    return replace(built.result, library=job.mixed(parts))


def probed(built: Built) -> BuildResult:
    """Return the submission's library with the probe in the place of its own trace_ray.

    Raises MixError when it cannot be linked, BuildError by the machine's fault.
    """
    job = built.job
    probe = job.compile_text(PROBE.name, PROBE.read_text(encoding="utf-8"))
    theirs = _weakened(built, [PROBED])
    parts = [(SHIM, built.shim), *{**built.objects, **theirs}.items(), (PROBE.name, probe)]
    return replace(built.result, library=job.mixed(parts))


def _weakened(built: Built, names: Collection[str]) -> dict[str, ObjectFile]:
    """Return the submission's objects, in which these functions give way to another's."""
    return {
        name: built.job.weakened(built.objects[name], sorted(symbols.defined & {*names}))
        for name, symbols in built.symbols.items()
    }
