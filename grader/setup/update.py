"""`make update ARCHIVE=new.zip`: a newer release over a folder where somebody is at work.

The student's own files are never touched; what else they changed is kept as a copy. Standard
library only: an update that was interrupted must be able to run again.
"""

from __future__ import annotations

import argparse
import contextlib
import difflib
import sys
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from io import BytesIO
from pathlib import Path, PurePosixPath

from grader.setup import c_text, release_record
from grader.setup.folding import put
from grader.setup.release_record import ORIGINALS, RECORD, HandoutError, Release, digest
from grader.setup.sentences import say
from grader.setup.transaction import Done, Plan, Step, replace

ROOT = Path(__file__).resolve().parent.parent.parent


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return 0, 1 when the update could not be made, 130 interrupted."""
    parser = argparse.ArgumentParser(prog="python -m grader update", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("archive", type=Path, nargs="?", metavar="ARCHIVE")
    parser.add_argument("--root", type=Path, default=ROOT, metavar="DIR")
    parser.add_argument("--force", action="store_true", help="go back to an older release too")
    options = parser.parse_args(arguments)
    try:
        if options.archive is None:
            raise HandoutError(say("setup.update_no_archive"))
        plan = prepare(options.archive, options.root, options.force)
        for sentence in _told(plan, replace(plan, options.root)):
            put(sentence, sys.stdout)
    except HandoutError as error:
        put(str(error), sys.stderr)
        return 1
    except KeyboardInterrupt:
        put(_again(), sys.stderr)
        return 130
    return 0


def prepare(archive: Path, root: Path, force: bool = False) -> Plan:
    """Compare the folder with what it was made from and with the archive. Raises HandoutError."""
    old = _installed(root)
    new, files = release_record.read(archive)
    if new.age < old.age and not force:
        raise HandoutError(say("setup.update_older", archive=archive))
    steps, kept = _steps(old, new, files, root)
    record = Step(RECORD, _content(root, RECORD), new.as_json(), False)
    if record.before != record.after:
        steps.append(record)
    return Plan(old, new, tuple(steps), tuple(kept), _news(kept, files, root))


def _installed(root: Path) -> Release:
    """Return the record of the folder itself."""
    try:
        return release_record.parse((root / RECORD).read_bytes())
    except (OSError, ValueError) as error:
        raise HandoutError(say("setup.update_not_handed_out", root=root, record=RECORD)) from error


def _steps(
    old: Release, new: Release, files: Mapping[str, bytes], root: Path
) -> tuple[list[Step], list[str]]:
    """Return what is to be written or removed, and the student's files that stay."""
    steps: list[Step] = []
    kept: list[str] = []
    own = {*old.own, *new.own}
    for path in sorted({*old.files, *files}):
        before, after = _content(root, path), files.get(path)
        theirs = before is not None and not _is(before, old.files.get(path, ""))
        # A notebook keeps answers and pictures: without news it stays as it is too.
        same = path.endswith(".ipynb") and old.files.get(path) == new.files.get(path)
        if theirs and (path in own or same) and before != after:
            kept.append(path)
        elif before != after and not (after is None and path in own):
            steps.append(Step(path, before, after, theirs))
    return steps, kept


def _content(root: Path, path: str) -> bytes | None:
    """Return a file's content; None when it is not there. Raises HandoutError."""
    place = root / path
    try:
        return place.read_bytes()
    except FileNotFoundError:
        if not place.is_symlink():
            return None
        detail = say("setup.link_to_nothing")
    except OSError as error:
        detail = error.strerror or str(error)
    raise HandoutError(say("setup.file_unread", path=path, detail=detail))


def _is(content: bytes, sha256: str) -> bool:
    """Whether a file is the one of that sum, however an editor or git ends its lines."""
    return sha256 in (digest(content), digest(content.replace(b"\r\n", b"\n")))


def _news(kept: Sequence[str], files: Mapping[str, bytes], root: Path) -> dict[str, str]:
    """Return how the starting files of the student's own have changed since the last release."""
    pack = _content(root, ORIGINALS)
    found = {}
    with contextlib.suppress(zipfile.BadZipFile), zipfile.ZipFile(BytesIO(pack or b"")) as archive:
        for path in kept:
            name = PurePosixPath(path).name
            if name not in archive.namelist() or path not in files:
                continue
            was, now = (
                each.decode("utf-8", errors="replace") for each in (archive.read(name), files[path])
            )
            if c_text.without_comments(was) == c_text.without_comments(now):
                continue  # perhaps in another language: nothing is to be carried over
            old, new = (each.splitlines(keepends=True) for each in (was, now))
            found[path] = "".join(difflib.unified_diff(old, new, f"old/{name}", f"new/{name}"))
    return found


# ---- Telling it ---------------------------------------------------------------------------------


def _told(plan: Plan, done: Done) -> Iterator[str]:
    if not plan.steps:
        yield say("setup.update_nothing_new")
        return
    added = sum(each.before is None for each in plan.steps)
    removed = sum(each.after is None for each in plan.steps)
    replaced = len(plan.steps) - added - removed
    yield say(
        "setup.updated",
        old=plan.old.title,
        new=plan.new.title,
        replaced=replaced,
        added=added,
        removed=removed,
    )
    if plan.kept:
        names = ", ".join(plan.kept)
        yield say("setup.update_yours", names=names)
    yield from _copies(plan, done)
    if plan.kept or any(step.theirs for step in plan.steps):
        yield say("setup.update_backup", backup=done.backup)


def _copies(plan: Plan, done: Done) -> Iterator[str]:
    """Say where the student finds what was replaced, and what is new in their starting files."""
    for step in plan.steps:
        if step.theirs:
            copy = done.beside.get(step.path) or f"{done.backup}/{step.path}"
            yield say("setup.update_copy", path=step.path, copy=copy)
    for path in plan.news:
        yield say("setup.update_news", path=path, backup=done.backup)


def _again() -> str:
    return say("setup.update_interrupted")


if __name__ == "__main__":
    sys.exit(main())
