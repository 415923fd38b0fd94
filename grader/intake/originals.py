"""The given files and the skeleton, as they were handed out.

A student works in `core_c/`, where the given files lie beside their own: once edited there, the
original is gone. The package therefore keeps a copy of what was handed out in one archive, made by
`make skeleton`. Where the solution is (not in a student's copy, whose `reference/` holds expected
data only), `core_c/` is the source of that archive, and is what others are judged with.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from grader.course import exercises
from grader.course.message import UserError
from grader.setup import c_text

PACK = exercises.PACKAGE / "intake" / "originals.zip"
REFERENCE = exercises.ROOT / "reference"
_UTF8_BOM = b"\xef\xbb\xbf"


class OriginalsError(UserError):
    """A file that was handed out cannot be read: the machine's fault."""


def names() -> tuple[str, ...]:
    """Return the names of the given files, then of the skeleton's."""
    rules = exercises.load()
    return (*rules.given, *rules.student)


def read(in_place: bool) -> Mapping[str, bytes]:
    """Return the files that were handed out, by name. `in_place`: core_c itself is judged.

    Raises OriginalsError.
    """
    return _from_pack(PACK) if in_place or not has_solution() else from_core()


def is_same(content: bytes, original: bytes) -> bool:
    """Whether a file is the original, however an editor ends its lines.

    Comments do not count: students may have them in another language.
    """
    return _plain(content) == _plain(original)


def untouched(files: Mapping[str, bytes], in_place: bool) -> frozenset[str]:
    """Return the names of the files that are still as they were handed out."""
    handed_out = read(in_place)
    return frozenset(
        name for name, content in files.items() if is_same(content, handed_out.get(name, b""))
    )


def has_solution() -> bool:
    """Whether the solution lies beside the grader: never in a student's copy."""
    return all((REFERENCE / name).is_file() for name in exercises.load().student)


def from_core() -> dict[str, bytes]:
    """Return the files of core_c/. Raises OriginalsError."""
    found = {}
    for name in names():
        try:
            found[name] = (exercises.CORE / name).read_bytes()
        except OSError as error:
            raise OriginalsError(
                "machine.given_missing", name=f"core_c/{name}", error=error.strerror
            ) from error
    return found


def _plain(content: bytes) -> str:
    text = content.removeprefix(_UTF8_BOM).replace(b"\r\n", b"\n")
    return c_text.without_comments(text.decode("latin-1")).strip()


def packed(files: Mapping[str, bytes]) -> bytes:
    """Return an archive of the files, the same bytes on every machine: stored, without dates.

    Its comments say whose each file is, to grader/setup/restore.py, which cannot read more.
    """
    out, rules = io.BytesIO(), exercises.load()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_STORED) as archive:
        for name, content in sorted(files.items()):
            entry = zipfile.ZipInfo(name)
            entry.comment = b"given" if name in rules.given else b"student"
            archive.writestr(entry, content)
    return out.getvalue()


@cache
def _from_pack(path: Path) -> Mapping[str, bytes]:
    try:
        with zipfile.ZipFile(path) as archive:
            return {name: archive.read(name) for name in names()}
    except (OSError, KeyError, zipfile.BadZipFile) as error:
        raise OriginalsError(
            "machine.given_missing", name=f"grader/intake/{path.name}", error=error
        ) from error
