"""Makes the expected data: inputs, and the reference's answers to them.

    python -m grader.authoring.expected.command [--seed N] [--out DIR] [--check]

The answers are made with the grader's own runner. Another seed and folder give an instructor data
that students have not seen, and the scenes from other cameras and in other colours:
`grade --expected DIR`. `--check` makes the data again and compares:
inputs must be the same, answers within half of their tolerance, for another compiler or libm may
round otherwise. The bank of known mistakes (mistake_bank.py) and the pictures (pictures/) are made
with the data.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import json
import shutil
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from grader.authoring.expected import mistake_bank
from grader.authoring.expected.pictures import drift, other_views
from grader.authoring.expected.vectors import glass, mirrors, octree, patterns, tp2, tp3, tp4, tp5
from grader.authoring.expected.vectors.maker import Recipe, Suite
from grader.build import toolchain
from grader.checking.comparison import far
from grader.checking.expected_data import (
    FOLDER,
    SIZE,
    Array,
    Batch,
    ExpectedError,
    encode,
    read,
    read_manifest,
)
from grader.evaluation.recognition import BANK
from grader.execution.session import Library, Limits, open_core
from grader.intake.originals import REFERENCE

SEED = 2015
PARTS = (tp2, tp3, patterns, tp4, mirrors, octree, tp5, glass)
ROUNDING = 1e-5


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code: 1 when the data has drifted."""
    parser = argparse.ArgumentParser(prog="python -m grader.authoring.expected.command")
    parser.add_argument("--seed", type=int, help=f"of the random inputs (default: {SEED})")
    parser.add_argument("--out", type=Path, default=FOLDER, help="folder (default: %(default)s)")
    parser.add_argument("--check", action="store_true", help="compare with what is there")
    parser.add_argument(
        "--without-bank", action="store_true", help="leave out the known mistakes' answers"
    )
    parser.add_argument(
        "--without-pictures", action="store_true", help="leave the pictures as they are"
    )
    parser.add_argument(
        "--without-views", action="store_true", help="leave the scenes' other views as they are"
    )
    options = parser.parse_args(arguments)
    with _reference() as core:
        try:
            if options.check:
                drifted = _check(core, options.out, options.seed) or mistake_bank.check(options.out)
                return drifted or drift.check(options.out)
            # First what takes longest: a failure leaves the functions' data and its bank alone.
            options.out.mkdir(parents=True, exist_ok=True)
            if not options.without_pictures:
                drift.store(options.out)
            seed = SEED if options.seed is None else options.seed
            if options.out.resolve() != FOLDER and not options.without_views:
                other_views.store(options.out, seed)
            _make(core, options.out, seed)
            if not options.without_bank:
                mistake_bank.store(options.out)
        except ExpectedError as error:
            print(error, file=sys.stderr)
            return 1
        except OSError as error:
            print(f"{error.filename}: {error.strerror}; choose another --out", file=sys.stderr)
            return 2
    return 0


@contextlib.contextmanager
def _reference() -> Iterator[Library]:
    with open_core(REFERENCE, *SIZE) as core:
        yield core


def recipes() -> list[Recipe]:
    """Return how every suite is made, in the order of the TPs."""
    return [each for part in PARTS for each in part.recipes()]


def suites(core: Library, seed: int) -> list[Suite]:
    """Return every suite of a seed, with the answers of the reference in it."""
    made = []
    for recipe in recipes():
        # A session of its own: no suite depends on what another one has left behind.
        with core.session(Limits(cpu=60)) as session:
            made.append(recipe.suite(core, session, seed))
    return made


def _make(core: Library, folder: Path, seed: int) -> None:
    """Write a folder of expected data: whole, or not at all."""
    made = suites(core, seed)
    with tempfile.TemporaryDirectory(dir=folder.parent) as part:
        files = {}
        for suite in made:
            batches = _batches(suite)
            content = encode(batches)
            (Path(part) / f"{suite.name}.npz").write_bytes(content)
            files[f"{suite.name}.npz"] = {
                "sha256": hashlib.sha256(content).hexdigest(),
                "calls": sum(each.count for each in batches),
                "tolerance": suite.tolerance,
                "reason": suite.reason,
            }
        manifest = {
            "command": f"python -m grader.authoring.expected.command --seed {seed}",
            "seed": seed,
            "size": list(SIZE),
            "compiler": toolchain.find_compiler().version.splitlines()[0],
            "files": dict(sorted(files.items())),
        }
        text = json.dumps(manifest, indent=1, ensure_ascii=False) + "\n"
        (Path(part) / "manifest.json").write_text(text, encoding="utf-8")
        _replace(folder, Path(part))


def _replace(folder: Path, part: Path) -> None:
    """Put the files in the place of the folder's old ones."""
    for old in folder.glob("*.npz"):
        old.unlink()
    for each in sorted(part.iterdir()):
        shutil.copyfile(each, folder / each.name)


def _batches(suite: Suite) -> list[Batch]:
    return [replace(each.batch, tolerance=suite.tolerance) for each in suite.questions]


def _check(core: Library, folder: Path, seed: int | None) -> int:
    """Compare a folder with what its seed gives now; say what has drifted."""
    stored = read_manifest(folder)
    made = suites(core, int(stored["seed"]) if seed is None else seed)
    names = {f"{each.name}.npz" for each in made}
    drifted = sorted(names ^ set(stored["files"]))
    drifted += [
        f"{path.name}: not in the manifest"
        for path in folder.glob("*.npz")
        if path.name not in (*names, BANK)
    ]
    for suite in made:
        if f"{suite.name}.npz" in stored["files"]:
            old = read(folder, suite.name, core)
            if not _same(old, _batches(suite)):
                drifted.append(f"{suite.name}.npz")
    for name in drifted:
        print(f"{folder}: {name} has drifted from the reference; run make expected")
    return 1 if drifted else 0


def _same(old: Sequence[Batch], new: Sequence[Batch]) -> bool:
    return len(old) == len(new) and all(map(_alike, old, new))


def _alike(old: Batch, new: Batch) -> bool:
    """Say whether two batches have the same inputs, and answers that rounding can explain."""
    settings = (old.function, old.count, old.tolerance, len(old.answers))
    if settings != (new.function, new.count, new.tolerance, len(new.answers)):
        return False
    for ours, theirs in ((old.args, new.args), (old.globals, new.globals)):
        if ours.keys() != theirs.keys() or not all(_near(ours[k], theirs[k]) for k in ours):
            return False
    return all(
        not far(after.result, before.result, max(old.tolerance / 2, ROUNDING)).any()
        for before, after in zip(old.answers, new.answers, strict=True)
        if before.result is not None and after.result is not None
    )


def _near(one: Array, other: Array) -> bool:
    """Say whether inputs are the same; numpy's sums differ by a rounding between processors."""
    if one.dtype.names:
        return all(_near(one[name], other[name]) for name in one.dtype.names)
    if one.shape != other.shape:
        return False
    if one.dtype.kind != "f":
        return bool((one == other).all())
    return bool(np.allclose(one, other, rtol=ROUNDING, atol=ROUNDING))


if __name__ == "__main__":
    sys.exit(main())
