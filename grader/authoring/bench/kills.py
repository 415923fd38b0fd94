"""A class of 20 whose batch, sandboxes and Dask workers are killed: the grades must not change.

    python -m grader.authoring.bench.kills [--build build] [--trials 10]

Each trial is a run of its own, with one kill -9 at a moment drawn from a seed: so many submissions
done, and a part of the next one. What is done is kept: the same command goes on where it was
stopped.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from grader.authoring.bench.programs import BenchError
from grader.authoring.specimens import classroom
from grader.course.exercises import ROOT

SIZE = 21  # with one that hangs, and is left out: it would take most of the time
TRIALS = 10
SEED = 7
JOBS = 2
SECONDS = 900  # a run that takes longer is stuck
START_SECONDS = 60
POLL_SECONDS = 0.05
_OUR_OWN = re.compile(r"grader\.batch\.worker|distributed|grader batch")


class Killing:
    """One class, its undisturbed grades, and the trials."""

    def __init__(self, folder: Path, size: int) -> None:
        self.folder = folder
        self.graded = 0  # submissions
        self.seconds = 0.0  # for one of them, in the undisturbed run
        shutil.rmtree(folder / "in", ignore_errors=True)
        for pupil in classroom.write(folder / "in", size):
            if pupil.hangs:
                shutil.rmtree(folder / "in" / pupil.name)
        self.expected = self._undisturbed()

    def _undisturbed(self) -> bytes:
        shutil.rmtree(self.folder / "whole", ignore_errors=True)
        start = time.monotonic()
        _end(self.start("whole"))
        self.graded = self.done("whole")
        self.seconds = (time.monotonic() - start) / self.graded
        return self.grades("whole")

    def start(self, name: str, *more: str) -> subprocess.Popen[bytes]:
        """Start the batch, or go on with it."""
        command = [sys.executable, "-m", "grader", "batch", str(self.folder / "in"), *more]
        command += ["--out", str(self.folder / name), "--jobs", str(JOBS), "--lang", "fr"]
        command += ["--public"]  # or each folder would have its own inputs
        with (self.folder / f"{name}.txt").open("ab") as said:
            return subprocess.Popen(command, cwd=ROOT, stdout=said, stderr=said)

    def grades(self, name: str) -> bytes:
        """Return grades.csv of a run."""
        return (self.folder / name / "grades.csv").read_bytes()

    def done(self, name: str) -> int:
        """Return how many submissions have their result."""
        return len(list((self.folder / name / "state").glob("*.json")))

    def wait(self, name: str, process: subprocess.Popen[bytes], chance: random.Random) -> None:
        """Wait for the moment."""
        count, part = chance.randrange(self.graded), chance.random()
        while self.done(name) < count and process.poll() is None:
            time.sleep(POLL_SECONDS)
        time.sleep(part * self.seconds)

    def batch(self, name: str, chance: random.Random) -> str:
        """Kill the command, then give it again."""
        process = self.start(name)
        self.wait(name, process, chance)
        process.kill()
        status, done = process.wait(), self.done(name)
        _end(self.start(name))
        return f"the batch ({status}) with {done} of {self.graded} done"

    def sandbox(self, name: str, chance: random.Random) -> str:
        """Kill a process of a sandbox, or the sandbox, and let the batch go on."""
        process = self.start(name)
        self.wait(name, process, chance)
        killed, done = "", self.done(name)
        while process.poll() is None and not killed:
            killed = _kill_one(sorted(_sandboxed(process.pid)), chance)
        _end(process)
        return f"{killed or 'nothing'} with {done} of {self.graded} done"

    def cluster(self, name: str, chance: random.Random) -> str:
        """Kill one of two Dask workers; another comes in its place."""
        with contextlib.ExitStack() as stack:
            address = _scheduler(stack)
            workers = [_worker(stack, address) for _ in range(JOBS)]
            process = self.start(name, "--scheduler", address)
            self.wait(name, process, chance)
            chance.choice(workers).kill()
            done = self.done(name)
            _worker(stack, address)
            _end(process)
        return f"a Dask worker with {done} of {self.graded} done"


Act = Callable[[Killing, str, random.Random], str]
ACTS: dict[str, Act] = {
    "batch": Killing.batch,
    "sandbox": Killing.sandbox,
    "cluster": Killing.cluster,
}


def _end(process: subprocess.Popen[bytes]) -> None:
    """Wait for a batch that must end well. Raises BenchError."""
    try:
        status = process.wait(SECONDS)
    finally:
        process.kill()
    if status != 0:
        raise BenchError(f"the batch ended with status {status}: {process.args!r}")


def _kill_one(processes: list[int], chance: random.Random) -> str:
    """Kill one of these processes; return what it was, "" when it had just gone."""
    if not processes:
        return ""
    pid = chance.choice(processes)
    try:
        words = Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
        os.kill(pid, signal.SIGKILL)
    except OSError:
        return ""
    shown = [word.decode(errors="replace").rpartition("/")[2] for word in words if word]
    return " ".join(shown[:1] + shown[-1:])


def _sandboxed(pid: int) -> Iterator[int]:
    """Yield the descendants of a process that are none of the batch's own."""
    for child in _children(pid):
        with contextlib.suppress(OSError):
            if not _OUR_OWN.search(_words(child)):
                yield child
        yield from _sandboxed(child)


def _words(pid: int) -> str:
    text = Path(f"/proc/{pid}/cmdline").read_text(encoding="utf-8", errors="replace")
    return text.replace("\0", " ")


def _children(pid: int) -> list[int]:
    found: list[int] = []
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        with contextlib.suppress(OSError):
            found += map(int, task.read_text(encoding="ascii").split())
    return found


def _scheduler(stack: contextlib.ExitStack) -> str:
    """Start a scheduler that ends with the stack; return its address."""
    command = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--no-dashboard"]
    command += ["--port", "0", "--host", "127.0.0.1"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    stack.callback(process.wait, START_SECONDS)
    stack.callback(process.kill)
    assert process.stderr is not None
    for line in process.stderr:
        if found := re.search(r"tcp://127\.0\.0\.1:\d+", line):
            return found[0]
    raise BenchError("the Dask scheduler does not start")


def _worker(stack: contextlib.ExitStack, address: str) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "distributed.cli.dask_worker", address]
    command += ["--nthreads", "1", "--no-dashboard", "--no-nanny"]
    process = subprocess.Popen(
        command,
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    stack.callback(process.wait, START_SECONDS)
    stack.callback(process.kill)
    return process


def run(folder: Path, trials: int, size: int) -> dict[str, str]:
    """Do the trials that are not done yet; return what came of each."""
    folder.mkdir(parents=True, exist_ok=True)
    kept = folder / "kept.json"
    done: dict[str, str] = json.loads(kept.read_text("utf-8")) if kept.exists() else {}
    wanted = [f"{act}-{number}" for number in range(trials) for act in ACTS]
    if set(wanted) <= set(done):
        return done
    killing = Killing(folder, size)
    for name in wanted:
        if name in done:
            continue
        chance = random.Random(f"{SEED} {name}")
        shutil.rmtree(folder / name, ignore_errors=True)
        try:
            what = ACTS[name.partition("-")[0]](killing, name, chance)
            same = killing.grades(name) == killing.expected
            done[name] = f"{'same' if same else 'CHANGED'}: {what}"
        except BenchError as error:
            done[name] = f"FAILED: {error}"
        kept.write_text(json.dumps(done, indent=1), encoding="utf-8")
        print(name, done[name], flush=True)
    return done


def main() -> int:
    """Run the command line; return 0, or 1 when a kill has changed the grades."""
    parser = argparse.ArgumentParser(
        prog="python -m grader.authoring.bench.kills", description=__doc__
    )
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--build", type=Path, default=Path("build"), metavar="DIR")
    parser.add_argument("--trials", type=int, default=TRIALS)
    parser.add_argument("--size", type=int, default=SIZE)
    options = parser.parse_args()
    try:
        done = run(options.build.absolute() / "bench" / "kills", options.trials, options.size)
    except (BenchError, OSError) as error:
        print(error, file=sys.stderr)
        return 1
    bad = {name: what for name, what in done.items() if not what.startswith("same")}
    print(f"{len(done) - len(bad)} kills of {len(done)} have left the grades as they were")
    for name, what in bad.items():
        print(f"  {name}: {what}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
