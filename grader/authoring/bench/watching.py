"""`make watch`: from a save to the verdict on the changed function, and to the end of the round.

In a terminal, as a person sees it: the reference's files, of which one function is edited.
"""

from __future__ import annotations

import contextlib
import os
import pty
import select
import shutil
import signal
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from grader.authoring.bench import waits
from grader.authoring.bench.programs import BenchError
from grader.commands.watch import ENDS
from grader.course import exercises
from grader.course.exercises import ROOT
from grader.files import write_whole
from grader.intake import definitions
from grader.lab.display.store import write_json

ROUNDS = 9
SECONDS = 60  # a round that takes longer is stuck
TP, EXERCISE, FUNCTION, FILE = 2, "TP2.4", "intersect_sphere", "raytracer.c"
# What is waited for, and how long at most, in seconds.
GOALS = {"save to the verdict": 0.35, "save to the whole TP": 1.0}


def measure(folder: Path) -> dict[str, float]:
    """Return the median seconds of each wait, on a copy of the reference. Raises BenchError."""
    place = folder / "watching"
    shutil.rmtree(place, ignore_errors=True)
    copy = place / "core_c"
    copy.mkdir(parents=True)
    for name in exercises.load().student:
        shutil.copyfile(ROOT / "reference" / name, copy / name)
    text = (copy / FILE).read_text(encoding="utf-8")
    taken: list[tuple[float, float]] = []
    with _watching(copy, place / "build") as terminal:
        _wait_for(terminal, f"\n{ENDS}")
        for _ in range(ROUNDS):
            write_whole(copy / FILE, edited(text, time.time_ns()))
            start = time.perf_counter()
            verdict, rest = _wait_for(terminal, EXERCISE)
            taken.append((verdict - start, _wait_for(terminal, f"\n{ENDS}", rest)[0] - start))
    found = dict(zip(GOALS, map(statistics.median, zip(*taken, strict=True)), strict=True))
    write_json(folder / "watching.json", {**found, "goals": GOALS})
    return found


def edited(text: str, number: int) -> str:
    """Return a file in which the function does something more, which changes nothing."""
    found = definitions.find(FUNCTION, {FILE: text})
    if found is None:
        raise BenchError(f"{FILE} has no {FUNCTION}")
    head, brace, body = found.text.partition("{")
    return text.replace(found.text, f"{head}{brace} (void){number}ull;{body}", 1)


@contextlib.contextmanager
def _watching(submission: Path, build: Path) -> Iterator[int]:
    """Start the command in a terminal of its own; yield the terminal's other end."""
    ours, theirs = pty.openpty()
    command = [sys.executable, "-m", "grader", "watch", str(submission), "--tp", str(TP)]
    variables = {**os.environ, "TERM": "xterm-256color", "COLUMNS": "100"}
    variables.pop("NO_COLOR", None)
    process = subprocess.Popen(
        [*command, "--build", str(build)],
        cwd=ROOT,
        env=variables,
        stdin=theirs,
        stdout=theirs,
        stderr=theirs,
        start_new_session=True,
    )
    os.close(theirs)
    try:
        yield ours
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(SECONDS)
        os.close(ours)


def _wait_for(terminal: int, word: str, seen: str = "") -> tuple[float, str]:
    """Read until a word is there; return when it was, and what came after it."""
    deadline = time.monotonic() + SECONDS
    while word not in seen:
        left = deadline - time.monotonic()
        if left <= 0 or not select.select([terminal], [], [], left)[0]:
            raise BenchError(f"make watch never says {word.strip()!r}")
        try:
            seen += os.read(terminal, 65536).decode(errors="replace")
        except OSError as error:  # it has ended
            raise BenchError(f"make watch has ended: {seen[-300:]}") from error
    return time.perf_counter(), seen.partition(word)[2]


def text(found: dict[str, float]) -> str:
    """Return a line for each wait."""
    return waits.text(
        f"make watch TP={TP}, {FUNCTION} edited (in a terminal, wall time)", found, GOALS
    )
