"""Makes the expected data: inputs, and the reference's answers to them.

    python -m grader.authoring.expected.command [--seed N] [--out DIR] [--check]
    python -m grader.authoring.expected.command --suite NAME | --picture NAME | --mistake NAME

The answers are made with the grader's own runner. Another seed and folder give an instructor data
that students have not seen, and the scenes from other cameras and in other colours:
`grade --expected DIR`. `--check` makes the data again and compares:
inputs must be the same, answers within half of their tolerance, for another compiler or libm may
round otherwise. The bank of known mistakes (mistake_bank.py) and the pictures (pictures/) are made
with the data. A suite, a picture or a mistake is made alone by its name (one.py).
"""

from __future__ import annotations

import argparse
import contextlib
import shutil
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from grader.authoring.expected import mistake_bank, one
from grader.authoring.expected.manifest import put, write_manifest
from grader.authoring.expected.pictures import drift, other_views
from grader.authoring.expected.suites import batches_of, file_of, suites
from grader.build import toolchain
from grader.checking.comparison import far
from grader.checking.expected_data import (
    FOLDER,
    SIZE,
    Array,
    Batch,
    ExpectedError,
    read,
    read_manifest,
)
from grader.course.message import GraderError
from grader.evaluation.recognition import BANK
from grader.execution.session import Library, open_core
from grader.intake.originals import REFERENCE

SEED = 2015
ROUNDING = 1e-5


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code: 1 when the data has drifted."""
    options = _parser().parse_args(arguments)
    with _reference() as core:
        try:
            if options.check:
                drifted = _check(core, options.out, options.seed) or mistake_bank.check(options.out)
                return drifted or drift.check(options.out)
            if not _made_one(core, options):
                _make_all(core, options)
        except GraderError as error:
            print(error, file=sys.stderr)
            return 1 if isinstance(error, ExpectedError) else error.code
        except OSError as error:
            print(f"{error.filename}: {error.strerror}; choose another --out", file=sys.stderr)
            return 2
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m grader.authoring.expected.command")
    parser.add_argument("--out", type=Path, default=FOLDER, help="folder (default: %(default)s)")
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--seed", type=int, help=f"of the random inputs (default: {SEED})")
    for name in ("suite", "picture", "mistake"):
        what.add_argument(f"--{name}", metavar="NAME", help=f"make one {name} again, alone")
    parser.add_argument("--check", action="store_true", help="compare with what is there")
    for name, left in (
        ("bank", "out the known mistakes' answers"),
        ("pictures", "the pictures as they are"),
        ("views", "the scenes' other views as they are"),
    ):
        parser.add_argument(f"--without-{name}", action="store_true", help=f"leave {left}")
    return parser


def _made_one(core: Library, options: argparse.Namespace) -> bool:
    """Make the one thing that is asked for; say whether there is one."""
    if options.suite:
        one.store_suite(core, options.out, options.suite)
    elif options.picture:
        one.store_picture(options.out, options.picture)
    elif options.mistake:
        one.store_mistake(options.out, options.mistake)
    return bool(options.suite or options.picture or options.mistake)


def _make_all(core: Library, options: argparse.Namespace) -> None:
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


@contextlib.contextmanager
def _reference() -> Iterator[Library]:
    with open_core(REFERENCE, *SIZE) as core:
        yield core


def _make(core: Library, folder: Path, seed: int) -> None:
    """Write a folder of expected data: whole, or not at all."""
    made = suites(core, seed)
    with tempfile.TemporaryDirectory(dir=folder.parent) as part:
        files: dict[str, Any] = {}
        for suite in made:
            files |= put(Path(part), *file_of(suite))
        manifest = {
            "command": f"python -m grader.authoring.expected.command --seed {seed}",
            "seed": seed,
            "size": list(SIZE),
            "compiler": toolchain.find_compiler().version.splitlines()[0],
            "files": files,
        }
        write_manifest(Path(part), manifest)
        _replace(folder, Path(part))


def _replace(folder: Path, part: Path) -> None:
    """Put the files in the place of the folder's old ones."""
    for old in folder.glob("*.npz"):
        old.unlink()
    for each in sorted(part.iterdir()):
        shutil.copyfile(each, folder / each.name)


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
            if not _same(old, batches_of(suite)):
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
