"""A class of every kind of submission, graded by one command: marks, the machine, time, memory.

    python -m grader.authoring.bench.batch [--size 1000] [--build build] [--jobs 2]

The same command goes on where it was stopped. Where root may, it works among processes and shared
folders of its own, so that nobody else's doings are taken for the batch's.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import re
import shutil
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grader.authoring.bench import grading, snapshot
from grader.authoring.bench.programs import BenchError
from grader.authoring.bench.report import Goal, goal_row, table
from grader.authoring.specimens import classroom
from grader.authoring.specimens.classroom import Pupil
from grader.batch import csv_table
from grader.console.run import ExitCode
from grader.course.exercises import ROOT
from grader.files import write_whole

SMALL = classroom.SIZE
RIGHT = ("full", "tp1", "skeleton")
JOBS = 2
POLL_SECONDS = 0.5
SECONDS = 4 * 3600  # a batch that takes longer is stuck
SETTLE_SECONDS = 10.0  # for the last processes to go
SHARED = [Path("/tmp"), Path("/var/tmp"), Path("/dev/shm")]
_APART = "MRT_BENCH_APART"
_HIGH_WATER = re.compile(r"^VmHWM:\s*(\d+) kB", re.MULTILINE)


@dataclass(frozen=True)
class Class:
    """What came of a class. Seconds and CPU are means over those that do not hang on purpose."""

    size: int
    graded: int
    wrong: tuple[str, ...]  # marks that are not the expected ones
    left: tuple[str, ...]  # on the machine
    seconds: float  # of wall time, on the jobs' cores together
    cpu: float
    peak_mb: float  # of the command and its workers; what submissions take is bounded by limits
    again_seconds: float  # the same from the cache
    ratios: Mapping[str, float]  # CPU / what it must take at least, by kind: grading.limit


def measure(folder: Path, size: int, jobs: int = JOBS) -> Class:
    """Grade a class of that size in a folder, or go on with it. Raises BenchError."""
    place = folder / f"class-{size}"
    shutil.rmtree(place / "in", ignore_errors=True)
    pupils = classroom.write(place / "in", size)
    kept = _Kept(place / "kept.json")
    before = _look()
    try:
        _run(place, jobs, kept)
    finally:
        kept.left(_differences(before))
    start = time.monotonic()
    _run(place, jobs, kept)
    again = time.monotonic() - start
    wrong = tuple(_wrong(pupils, place / "out" / "grades.csv"))
    states = list(_states(pupils, place / "out" / "state"))
    calm = [each for each in states if not _hung(*each)]
    return Class(
        size,
        len(states),
        wrong,
        tuple(kept.content["left"]),
        statistics.mean(state["seconds"] for _, state in calm) / jobs,
        statistics.mean(state["cpu"] for _, state in calm),
        kept.content["peak_mb"],
        again,
        _ratios(place, calm),
    )


def _ratios(place: Path, calm: Sequence[tuple[Pupil, Mapping[str, Any]]]) -> dict[str, float]:
    """Return the mean CPU of each right kind, by that which one of the kind must take."""
    spent: dict[str, list[float]] = {kind: [] for kind in RIGHT}
    names = {}
    for pupil, state in calm:
        if pupil.kind in spent:
            spent[pupil.kind].append(state["cpu"])
            names[pupil.kind] = pupil.name
    return {
        kind: statistics.mean(spent[kind])
        / grading.limit(place / "in" / name / classroom.INSIDE, place / "cache")
        for kind, name in names.items()
    }


class _Kept:
    """What must outlive a bench that is stopped."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.content: dict[str, Any] = {"peak_mb": 0.0, "left": []}
        with contextlib.suppress(OSError, ValueError):
            self.content |= json.loads(path.read_text(encoding="utf-8"))

    def peak(self, megabytes: float) -> None:
        """Note what the processes take now."""
        if megabytes > self.content["peak_mb"]:
            self.content["peak_mb"] = megabytes
            self._write()

    def left(self, lines: Sequence[str]) -> None:
        """Note what is left on the machine."""
        self.content["left"] += lines
        self._write()

    def _write(self) -> None:
        write_whole(self._path, json.dumps(self.content, indent=1))


def _run(place: Path, jobs: int, kept: _Kept) -> None:
    command = [sys.executable, "-m", "grader", "batch", str(place / "in"), "--lang", "fr"]
    command += ["--out", str(place / "out"), "--jobs", str(jobs), "--names"]
    start = time.monotonic()
    with (
        (place / "said.txt").open("a", encoding="utf-8") as said,
        subprocess.Popen(command, cwd=ROOT, stdout=said, stderr=said) as process,
    ):
        while process.poll() is None:
            kept.peak(sum(map(_megabytes, [process.pid, *_workers(process.pid)])))
            if time.monotonic() - start > SECONDS:
                process.kill()
            time.sleep(POLL_SECONDS)
    if process.returncode not in (ExitCode.DONE, ExitCode.FAILED):  # marks tell the second
        raise BenchError(f"the batch ended with {process.returncode}: see {place / 'said.txt'}")


def _workers(command: int) -> Iterator[int]:
    with contextlib.suppress(OSError):  # it has just ended
        children = Path(f"/proc/{command}/task/{command}/children").read_text(encoding="ascii")
        yield from map(int, children.split())


def _megabytes(process: int) -> float:
    """Return the most memory that a process has had; 0 when it is gone."""
    with contextlib.suppress(OSError):
        found = _HIGH_WATER.search(Path(f"/proc/{process}/status").read_text(encoding="utf-8"))
        return int(found[1]) / 1000 if found else 0.0
    return 0.0


# ---- What must come of it -----------------------------------------------------------------------


def _wrong(pupils: Sequence[Pupil], path: Path) -> Iterator[str]:
    """Yield a line for each submission whose lines of grades.csv are not the expected ones."""
    sheet = csv_table.read(path)
    name, points = (sheet.header.index(each) for each in ("rendu", "points"))  # of 20
    found: dict[str, list[float | None]] = {}
    for row in sheet.rows:
        found.setdefault(row[name], []).append(csv_table.number(row[points]))
    for pupil in pupils:
        due = None if pupil.points is None else round(pupil.points / 5, 3)
        expected = [due] * max(1, len(pupil.members))
        if found.get(pupil.name) != expected:
            yield f"{pupil.name} ({pupil.kind}): {found.get(pupil.name)} for {expected}"


def _states(pupils: Sequence[Pupil], folder: Path) -> Iterator[tuple[Pupil, Mapping[str, Any]]]:
    for each in pupils:
        path = folder / f"{each.name}.json"
        if path.is_file():
            yield each, json.loads(path.read_text(encoding="utf-8"))


def _hung(pupil: Pupil, state: Mapping[str, Any]) -> bool:
    return pupil.hangs or "timeout" in state["summary"]["checks"].values()


def _look() -> snapshot.Snapshot:
    # The files of who runs this, and the project's own.
    return snapshot.take([Path.home(), ROOT])


def _differences(before: snapshot.Snapshot) -> list[str]:
    """Return what was not there before, once the last processes have had time to end."""
    deadline = time.monotonic() + SETTLE_SECONDS
    while (found := snapshot.differences(before, _look())) and time.monotonic() < deadline:
        time.sleep(POLL_SECONDS)
    return found


# ---- What is told -------------------------------------------------------------------------------


def goals(found: Class, small: Class | None) -> list[Goal]:
    """Return the goals; `small` is a class of SMALL, with which a larger one is compared."""
    told = [
        Goal("marks that are not as expected", len(found.wrong), 0),
        Goal("things left or changed on the machine", len(found.left), 0),
        Goal(f"seconds of wall time each, on {JOBS} cores", found.seconds, 1),
        Goal("seconds for all, from the cache", found.again_seconds, 5 * found.size / SMALL),
    ]
    told += [Goal(f"CPU / the limit: {kind}", each, 1.3) for kind, each in found.ratios.items()]
    if small:
        told.append(Goal(f"CPU of each / in a class of {small.size}", found.cpu / small.cpu, 1.1))
        ratio = found.peak_mb / small.peak_mb
        told.append(Goal(f"peak memory / with a class of {small.size}", ratio, 1.1))
    return told


def text(found: Class, small: Class | None = None) -> str:
    """Return what a person reads."""
    lines = [
        f"A class of {found.size}, {found.graded} of them graded: {found.cpu:.2f} s of CPU each, "
        f"{found.peak_mb:.0f} MB"
    ]
    lines += [f"  not as expected: {each}" for each in found.wrong]
    lines += [f"  on the machine: {each}" for each in found.left[:20]]
    return "\n".join([*lines, table([goal_row(each) for each in goals(found, small)])])


# ---- On its own ---------------------------------------------------------------------------------


def _apart() -> None:
    """Go on in this process' place with processes and shared folders of our own, where root may."""
    if os.environ.get(_APART) or os.geteuid() != 0 or not shutil.which("unshare"):
        return
    command = ["unshare", "--mount", "--pid", "--ipc", "--fork", "--kill-child", "--mount-proc"]
    if subprocess.run([*command, "true"], capture_output=True, timeout=20, check=False).returncode:
        return
    os.environ[_APART] = "1"
    own = [sys.executable, "-m", "grader.authoring.bench.batch", *sys.argv[1:]]
    os.execvp(command[0], [*command, *own])


def _own_folders() -> None:
    """Have empty folders in the place of the shared ones, and of the home where that may be."""
    home = Path.home()
    needed = [ROOT, Path(sys.base_prefix), Path(sys.prefix), Path.cwd()]
    hidden = [] if any(home in (each, *each.parents) for each in needed) else [home]
    for each in [*SHARED, *hidden]:
        mount = ["mount", "-t", "tmpfs", "-o", "mode=1777", "tmpfs", str(each)]
        subprocess.run(mount, timeout=20, check=True)


def main() -> int:
    """Run the command line; return 0, or 1 when something could not be measured."""
    parser = argparse.ArgumentParser(
        prog="python -m grader.authoring.bench.batch", description=__doc__
    )
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--build", type=Path, default=Path("build"), metavar="DIR")
    parser.add_argument("--size", type=int, default=SMALL)
    parser.add_argument("--jobs", type=int, default=JOBS)
    options = parser.parse_args()
    folder = options.build.absolute() / "bench"
    _apart()
    try:
        if os.environ.get(_APART):
            _own_folders()
        folder.mkdir(parents=True, exist_ok=True)
        small = measure(folder, SMALL, options.jobs) if options.size > SMALL else None
        print(text(measure(folder, options.size, options.jobs), small))
    except (BenchError, OSError, subprocess.SubprocessError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
