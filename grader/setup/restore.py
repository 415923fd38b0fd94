"""`make restore`: those given files of core_c/ that are no longer as they were handed out.

    python -m grader.setup.restore            puts them back, and keeps a copy of what was changed
    python -m grader.setup.restore --check    only names them, on stderr; `make mrt` asks

The student's own files are never touched. Standard library only: `make mrt` needs no package.
"""

from __future__ import annotations

import os
import sys
import time
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from grader.setup import c_text
from grader.setup.folding import put
from grader.setup.release_record import ORIGINALS, HandoutError
from grader.setup.sentences import say, tell
from grader.setup.transaction import free

ROOT = Path(__file__).resolve().parent.parent.parent
CORE = "core_c"
GIVEN = b"given"  # the comment, in originals.zip, of a file that is not the student's


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return 0, 1 when a file is missing or could not be put back."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    try:
        handed_out = given(ROOT)
        if words == ["--check"]:
            missing, changed = faults(ROOT, handed_out, comments=False)
            _name(missing, changed)
            return 1 if missing else 0
        missing, changed = faults(ROOT, handed_out)
        backup = put_back(ROOT, handed_out, missing, changed)
        put("\n".join(_told(missing, changed, backup)), sys.stdout)
    except HandoutError as error:
        put(str(error), sys.stderr)
        return 1
    return 0


def given(root: Path) -> dict[str, bytes]:
    """Return the given files as they were handed out. Raises HandoutError."""
    try:
        with zipfile.ZipFile(root / ORIGINALS) as archive:
            entries = [each for each in archive.infolist() if each.comment == GIVEN]
            return {each.filename: archive.read(each) for each in entries}
    except (OSError, zipfile.BadZipFile) as error:
        raise HandoutError(say("setup.originals_damaged", path=ORIGINALS, error=error)) from error


def faults(
    root: Path, handed_out: Mapping[str, bytes], comments: bool = True
) -> tuple[list[str], list[str]]:
    """Return the names of the given files that are not there, and of those that are otherwise.

    Without comments only their code counts, as for a mark.
    """
    missing, changed = [], []
    for name, original in handed_out.items():
        try:
            content = (root / CORE / name).read_bytes()
        except FileNotFoundError:
            missing.append(name)
        except OSError:
            changed.append(name)
        else:
            if _plain(content, comments) != _plain(original, comments):
                changed.append(name)
    return missing, changed


def _plain(content: bytes, comments: bool) -> str:
    """Return a content however an editor or git ends its lines."""
    text = content.removeprefix(b"\xef\xbb\xbf").replace(b"\r\n", b"\n").decode("latin-1")
    return (text if comments else c_text.without_comments(text)).strip()


def _name(missing: Sequence[str], changed: Sequence[str]) -> None:
    if missing:
        names = ", ".join(f"{CORE}/{name}" for name in missing)
        tell("setup.given_missing", names=names)
    if changed:
        names = ", ".join(f"{CORE}/{name}" for name in changed)
        tell("setup.given_changed", names=names)


def put_back(
    root: Path, handed_out: Mapping[str, bytes], missing: Sequence[str], changed: Sequence[str]
) -> Path:
    """Put the originals back; return where the changed files were put. Raises HandoutError.

    What can fail, a full disk or a closed folder, fails before anything has changed.
    """
    place = root / CORE
    backup = free(root / time.strftime("sauvegarde-%Y-%m-%d-%H%M%S"))
    parts = {name: place / f".{name}.part" for name in (*missing, *changed)}
    try:
        for name, part in parts.items():
            part.write_bytes(handed_out[name])
        if changed:
            (backup / CORE).mkdir(parents=True)
        for name, part in parts.items():
            if name in changed:  # whatever it is now: a link, a folder
                os.replace(place / name, backup / CORE / name)
            part.replace(place / name)
    except OSError as error:
        raise _unwritable(error, root) from error
    finally:
        for part in parts.values():
            part.unlink(missing_ok=True)
    return backup


def _unwritable(error: OSError, root: Path) -> HandoutError:
    place = os.path.relpath(error.filename or root, root)
    return HandoutError(say("setup.restore_unwritable", place=place, error=error.strerror))


def _told(missing: Sequence[str], changed: Sequence[str], backup: Path) -> Iterator[str]:
    if not (missing or changed):
        yield say("setup.given_intact")
        return
    names = ", ".join((*missing, *changed))
    yield say("setup.restored", folder=CORE, names=names)
    if changed:
        yield say("setup.restore_kept", backup=backup.name, folder=CORE)


if __name__ == "__main__":
    sys.exit(main())
