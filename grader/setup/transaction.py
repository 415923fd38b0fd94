"""Replaces the files of a folder: all of them, or none.

The new files are first written beside the old ones: what can fail (a full disk, a closed folder)
fails there, before anything has changed. Then they are renamed, the record last; when one resists,
the old ones are put back. Killed in between, the same update can be run again.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from grader.setup.release_record import RECORD, HandoutError, Release
from grader.setup.sentences import say

# Renamed together, after all the rest: what an interrupted update needs is all old, or all new.
_LAST = (
    *(
        f"grader/setup/{name}.py"
        for name in ("c_text", "folding", "sentences", "release_record", "transaction", "update")
    ),
    RECORD,
)

_STAGED = ".mrt-new"


@dataclass(frozen=True)
class Step:
    """One file to write, or to remove when `after` is None; `before` is None when it is new."""

    path: str
    before: bytes | None
    after: bytes | None
    theirs: bool  # the student has changed it: a copy is kept


@dataclass(frozen=True)
class Plan:
    """What an update does. `kept` are the student's files, which stay as they are."""

    old: Release
    new: Release
    steps: tuple[Step, ...]
    kept: tuple[str, ...]
    news: Mapping[str, str]  # by student's file: what the new starting file has more, as a diff


@dataclass(frozen=True)
class Done:
    """Where copies were put: a folder, and beside their original the student's notebooks."""

    backup: str
    beside: Mapping[str, str] = field(default_factory=dict)


class _HalfDoneError(Exception):
    """Neither the new files nor the old ones could be put in place."""


def replace(plan: Plan, root: Path) -> Done:
    """Make the update. Raises HandoutError: nothing has changed, unless it says otherwise."""
    if not plan.steps:
        return Done("")
    backup = free(root / time.strftime("sauvegarde-%Y-%m-%d-%H%M%S"))
    beside = {
        step.path: free(place.with_stem(f"{place.stem}-ma-version"))
        for step in plan.steps
        for place in [root / step.path]
        if step.theirs and step.path.endswith(".ipynb")
    }
    try:
        _copy(plan, root, backup, beside)
        _stage(plan, root)
        _rename(plan, root)
    except _HalfDoneError as error:
        raise _half_done(error.__cause__, root) from error
    except BaseException as error:
        shutil.rmtree(backup, ignore_errors=True)
        _discard(beside.values())
        if isinstance(error, OSError):
            raise _not_done(error, root) from error
        raise
    finally:
        _discard(_staged(root / step.path) for step in plan.steps)
    _prune(plan, root)
    names = {path: os.path.relpath(place, root) for path, place in beside.items()}
    return Done(backup.name, names)


def free(path: Path) -> Path:
    """Return the path, with a number when it is taken."""
    number, free = 1, path
    while free.exists() or free.is_symlink():
        number += 1
        free = path.with_stem(f"{path.stem}-{number}")
    return free


def _staged(place: Path) -> Path:
    """Return where a file waits before it is renamed: on the same disk."""
    return place.with_name(f".{place.name}{_STAGED}")


def _copy(plan: Plan, root: Path, backup: Path, beside: Mapping[str, Path]) -> None:
    """Keep a copy of what is the student's, and how their starting files have changed."""
    copies = {path: (root / path).read_bytes() for path in plan.kept}
    copies |= {step.path: step.before or b"" for step in plan.steps if step.theirs}
    copies |= {f"{path}.diff": text.encode() for path, text in plan.news.items()}
    for path, content in copies.items():
        _write(backup / path, content)
    for path, place in beside.items():
        _write(place, copies[path])


def _stage(plan: Plan, root: Path) -> None:
    for step in plan.steps:
        if step.after is not None:
            _write(_staged(root / step.path), step.after)


def _write(path: Path, content: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        path.write_bytes(content)
    except OSError as error:
        error.filename = str(path)  # a full disk does not say what it had no room for
        raise


def _discard(paths: Iterable[Path]) -> None:
    """Remove files; what cannot be removed stays, hidden and harmless."""
    for path in paths:
        try:
            path.unlink(missing_ok=True)
        except OSError:
            continue


def _rename(plan: Plan, root: Path) -> None:
    """Put every new file in its place; when one resists, put all the old ones back."""
    done: list[Step] = []
    try:
        for step in sorted(plan.steps, key=_rank):
            place = root / step.path
            if step.after is None:
                place.unlink(missing_ok=True)
            else:
                _staged(place).replace(place)
            done.append(step)
    except BaseException as error:
        try:
            for step in reversed(done):
                _put_back(step, root / step.path)
        except OSError:
            raise _HalfDoneError from error
        raise


def _prune(plan: Plan, root: Path) -> None:
    """Remove the folders that the update has left empty, but for what Python keeps there."""
    left = {root / each.path for each in plan.steps if each.after is None}
    folders = {above for path in left for above in path.parents if root in above.parents}
    for folder in sorted(folders, key=lambda each: len(each.parts), reverse=True):
        with contextlib.suppress(OSError):
            if [each.name for each in folder.iterdir()] == ["__pycache__"]:
                shutil.rmtree(folder / "__pycache__")
            folder.rmdir()


def _rank(step: Step) -> int:
    return _LAST.index(step.path) + 1 if step.path in _LAST else 0


def _put_back(step: Step, place: Path) -> None:
    if step.before is None:
        place.unlink(missing_ok=True)
    else:
        _write(_staged(place), step.before)
        _staged(place).replace(place)


def _reason(error: BaseException | None, root: Path) -> str:
    if not isinstance(error, OSError):
        return str(root)
    place = Path(os.path.relpath(error.filename2 or error.filename or root, root))
    if place.name.endswith(_STAGED):
        place = place.with_name(place.name[1 : -len(_STAGED)])
    return f"{place} ({error.strerror})"


def _not_done(error: OSError, root: Path) -> HandoutError:
    reason = _reason(error, root)
    return HandoutError(say("setup.unwritable", reason=reason))


def _half_done(error: BaseException | None, root: Path) -> HandoutError:
    reason = _reason(error, root)
    return HandoutError(say("setup.half_done", reason=reason))
