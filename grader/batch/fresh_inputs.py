"""Inputs that no student has seen: from a seed of the course's own, beside its results.

    inputs/seed    drawn once for the folder of results
    inputs/data/   what is made of it, put there whole; again when the suites or the solution change

The folder is closed, so that what runs as another user cannot even look for the seed.
"""

from __future__ import annotations

import secrets
import shutil
import subprocess
import sys
from pathlib import Path

from grader.batch.records import BatchError
from grader.course import exercises
from grader.course.exercises import PACKAGE, ROOT
from grader.files import closed_folder, content_key, write_whole
from grader.intake import originals

FOLDER = "inputs"  # of the results
SECONDS = 600  # of the wall clock: a back-stop, also on a busy machine
_SEED, _DATA, _MADE_OF = "seed", "data", "made_of"
_SEEDS = 1 << 31
_MOST = 300  # characters of what went wrong
_MAKER = "grader.authoring.expected.command"  # of a later stage: a process of its own


def are_possible() -> bool:
    """Say whether they can be made: where the solution is."""
    return originals.has_solution()


def prepared(out: Path, work: Path) -> tuple[int, Path]:
    """Return the seed of a folder of results, and what is made of it; `work` is for what is begun.

    Raises BatchError, OSError.
    """
    folder = out / FOLDER
    closed_folder(folder)
    seed = _seed(folder / _SEED)
    data = folder / _DATA
    if not _is_made(data, seed):
        part = work / FOLDER
        make(seed, part)
        if data.exists():
            data.rename(work / f"{FOLDER}.old")
        part.rename(data)
    return seed, data


def make(seed: int, folder: Path) -> None:
    """Make the expected data of a seed in a folder. Raises BatchError, OSError."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    words = ["--seed", str(seed), "--out", str(folder), "--without-pictures", "--without-bank"]
    try:
        done = subprocess.run(
            [sys.executable, "-m", _MAKER, *words],
            cwd=ROOT,
            capture_output=True,
            text=True,
            timeout=SECONDS,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise BatchError("batch.no_inputs", path=folder, error=f"> {SECONDS} s") from error
    if done.returncode:
        lines = done.stderr.strip().splitlines() or [str(done.returncode)]
        raise BatchError("batch.no_inputs", path=folder, error=lines[-1][:_MOST])
    write_whole(folder / _MADE_OF, _key(seed))


def _seed(path: Path) -> int:
    """Return the seed that is kept; a new one where there is none."""
    try:
        return int(path.read_text(encoding="ascii"))
    except (FileNotFoundError, ValueError):
        seed = secrets.randbelow(_SEEDS)
        write_whole(path, f"{seed}\n")
        return seed


def _is_made(data: Path, seed: int) -> bool:
    try:
        return (data / _MADE_OF).read_text(encoding="ascii") == _key(seed)
    except (OSError, ValueError):
        return False


def _key(seed: int) -> str:
    """Return a name for all that the data depend on."""
    paths = [*(PACKAGE / "authoring" / "expected").rglob("*.py"), *PACKAGE.glob("checking/*.py")]
    paths += originals.REFERENCE.glob("*.[ch]")
    paths += [exercises.CORE / name for name in exercises.load().given]
    return content_key(seed, [path.read_bytes() for path in sorted(paths)])
