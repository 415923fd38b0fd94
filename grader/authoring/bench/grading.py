"""How long a grade takes: the reference, as a submission that was never seen."""

from __future__ import annotations

import os
import resource
import shutil
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from grader.authoring.bench.programs import BenchError
from grader.build import toolchain
from grader.build.records import Target
from grader.course import exercises
from grader.course.sizes import PICTURE, UNIT
from grader.sandbox import orphans

ROUNDS = 5
SECONDS = 120  # a grade that takes longer is stuck
POLL_SECONDS = 0.02
FUNCTIONS = [each for each, rule in exercises.load().checks().items() if not rule.is_picture]
# What is asked of `make grade`, and the files that are edited before: all, or one.
RUNS: Mapping[str, tuple[Mapping[str, str], Sequence[str]]] = {
    "whole": ({}, exercises.load().student),
    "units": ({"K": " ".join(FUNCTIONS)}, exercises.load().student),
    "one": ({"TP": "2", "K": "sphere"}, ["raytracer.c"]),
}


@dataclass(frozen=True)
class TimedGrade:
    """Seconds of wall time and of CPU, those of all processes; medians."""

    wall: float
    cpu: float


@dataclass(frozen=True)
class Grading:
    """What grading the reference costs.

    `limit` is the CPU of compiling its files, sanitized and optimised, and of its own functions in
    the checks; `canary` the wall time of proving the isolation; both in seconds. `peak_mb` is the
    memory of all processes together, at most.
    """

    grades: Mapping[str, TimedGrade]  # by RUNS
    limit: float
    canary: float
    peak_mb: float


def measure(folder: Path) -> Grading:
    """Grade the reference whole, then its functions alone, then one exercise of it."""
    build = folder / "grading"
    submission = folder / "submission"
    shutil.rmtree(submission, ignore_errors=True)
    submission.mkdir(parents=True)
    for name in exercises.load().student:
        shutil.copy(exercises.ROOT / "reference" / name, submission)
    orphans.adopt()  # so that their CPU is counted
    # Warms the caches, too; to look at every process takes time of its own.
    peak = max(_watched(_command(submission, build, {})))
    return Grading(
        {name: _median(_rounds(submission, build, *RUNS[name])) for name in RUNS},
        limit(submission, build / "cache"),
        _canary(),
        peak,
    )


def limit(submission: Path, cache: Path) -> float:
    """Return the CPU seconds that grading a submission must take at least, as in Grading."""
    return _compiling(submission) + _inside(submission, cache)


def _rounds(
    submission: Path, build: Path, settings: Mapping[str, str], edited: Sequence[str]
) -> Iterator[TimedGrade]:
    for _ in range(ROUNDS):
        for name in edited:
            # A comment that was never there: nothing of the file is in a cache.
            with (submission / name).open("a", encoding="utf-8") as out:
                out.write(f"/* {time.time_ns()} */\n")
        before, start = _cpu(), time.monotonic()
        _check(_command(submission, build, settings))
        wall = time.monotonic() - start
        orphans.sweep()
        yield TimedGrade(wall, _cpu() - before)


def _median(grades: Iterator[TimedGrade]) -> TimedGrade:
    found = list(grades)
    return TimedGrade(
        statistics.median(each.wall for each in found),
        statistics.median(each.cpu for each in found),
    )


def _command(submission: Path, build: Path, settings: Mapping[str, str]) -> list[str]:
    values = {**settings, "SUBMISSION": str(submission), "BUILD": str(build)}
    return ["make", "-s", "grade", *(f"{name}={value}" for name, value in values.items())]


def _watched(command: Sequence[str]) -> Iterator[float]:
    """Run a command; yield the memory of its processes, in MB, again and again."""
    start = time.monotonic()
    with subprocess.Popen(command, cwd=exercises.ROOT, stdout=subprocess.DEVNULL) as grade:
        while grade.poll() is None:
            yield _megabytes(grade.pid)
            if time.monotonic() - start > SECONDS:
                grade.kill()
            time.sleep(POLL_SECONDS)
    if grade.returncode != 0:
        raise BenchError(f"grading the reference ended with status {grade.returncode}")


def _cpu() -> float:
    """Return the CPU seconds of the children that have ended, and of theirs."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def _compiling(submission: Path) -> float:
    """Return the CPU seconds of compiling the submission's files for functions and pictures."""
    compiler = toolchain.find_compiler()
    sanitized = bool(toolchain.sanitizer_runtime(compiler))

    def compile_all() -> None:
        for target in (Target(*UNIT, sanitized), Target(*PICTURE)):
            flags = toolchain.compile_flags(compiler, target)
            for source in sorted(submission.glob("*.c")):
                command = [*compiler.command, *flags, "-iquote", str(exercises.CORE)]
                _check([*command, "-c", str(source), "-o", os.devnull])

    return _median_of(_cpu, compile_all)


def _inside(submission: Path, cache: Path) -> float:
    """Return the CPU seconds of the submission's own functions in its checks."""
    command = [sys.executable, "-m", "grader.authoring.bench.inside", str(submission), str(cache)]
    return statistics.median(float(_check(command)) for _ in range(ROUNDS))


def _canary() -> float:
    """Return the wall time of the command that proves the isolation."""
    command = [sys.executable, "-m", "grader.execution.canary"]
    _check(command)  # builds its library
    return _median_of(time.monotonic, lambda: _check(command))


def _median_of(clock: Callable[[], float], act: Callable[[], object]) -> float:
    """Return by how much a clock goes on while something is done."""
    found = []
    for _ in range(ROUNDS):
        start = clock()
        act()
        found.append(clock() - start)
    return statistics.median(found)


def _check(command: Sequence[str]) -> str:
    """Run a command; return what it prints. Raises BenchError when it fails."""
    done = subprocess.run(
        command, cwd=exercises.ROOT, capture_output=True, text=True, timeout=SECONDS, check=False
    )
    if done.returncode != 0:
        raise BenchError(f"{command[0]} ended with status {done.returncode}: {done.stderr[:300]}")
    return done.stdout


def _megabytes(root: int) -> float:
    """Return the resident memory of a process and all that came from it; 0 without /proc."""
    parents, pages = {}, {}
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            fields = (entry / "stat").read_text(errors="replace").rpartition(")")[2].split()
        except OSError:
            continue  # it has just gone
        parents[int(entry.name)] = int(fields[1])
        pages[int(entry.name)] = int(fields[21])
    family = {root}
    for _ in range(8):  # generations: a grade has five
        family |= {pid for pid, parent in parents.items() if parent in family}
    return sum(pages.get(pid, 0) for pid in family) * os.sysconf("SC_PAGESIZE") / 1e6
