"""How long a grade takes: the reference, as a submission that was never seen."""

from __future__ import annotations

import os
import resource
import shutil
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from grader import manifest
from grader.dev.bench.programs import BenchError

ROUNDS = 3
SECONDS = 120  # a grade that takes longer is stuck
POLL_SECONDS = 0.02
WHOLE: tuple[str, ...] = ()
ONE = ("--tp", "2", "-k", "sphere")


@dataclass(frozen=True)
class Grade:
    """Seconds of wall time and of CPU, medians; the most memory of all processes together.

    The CPU of what ran in a sandbox is not in it: its processes are not waited for by ours.
    """

    wall: float
    cpu: float
    peak_mb: float


def measure(folder: Path) -> dict[str, Grade]:
    """Grade the reference whole, then one exercise of it after an edit of its file."""
    build = folder / "grading"
    submission = folder / "submission"
    shutil.rmtree(submission, ignore_errors=True)
    submission.mkdir(parents=True)
    for name in manifest.load().student:
        shutil.copy(manifest.ROOT / "reference" / name, submission)
    _run(submission, build, WHOLE)  # warms the caches
    return {
        "whole": _median(_rounds(submission, build, WHOLE, manifest.load().student)),
        "one": _median(_rounds(submission, build, ONE, ["raytracer.c"])),
    }


def _rounds(
    submission: Path, build: Path, options: Sequence[str], edited: Sequence[str]
) -> Iterator[Grade]:
    for _ in range(ROUNDS):
        for name in edited:
            # A comment that was never there: nothing of the file is in a cache.
            with (submission / name).open("a", encoding="utf-8") as out:
                out.write(f"/* {time.time_ns()} */\n")
        yield _run(submission, build, options)


def _median(grades: Iterator[Grade]) -> Grade:
    found = list(grades)
    return Grade(
        statistics.median(each.wall for each in found),
        statistics.median(each.cpu for each in found),
        max(each.peak_mb for each in found),
    )


def _run(submission: Path, build: Path, options: Sequence[str]) -> Grade:
    command = [sys.executable, "-m", "grader", "grade", str(submission), *options]
    command += ["--build", str(build)]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    start, peak = time.monotonic(), 0.0
    with subprocess.Popen(command, cwd=manifest.ROOT, stdout=subprocess.DEVNULL) as grade:
        while grade.poll() is None:
            peak = max(peak, _megabytes(grade.pid))
            if time.monotonic() - start > SECONDS:
                grade.kill()
            time.sleep(POLL_SECONDS)
        wall = time.monotonic() - start
    if grade.returncode != 0:
        raise BenchError(f"grading the reference ended with status {grade.returncode}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return Grade(wall, cpu, peak)


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
