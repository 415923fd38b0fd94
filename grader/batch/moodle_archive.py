"""A Moodle "download all submissions" archive, taken apart: what may be graded, and no more.

Entries are written under names of our own making, one by one; an unsafe one is refused and the rest
goes on.
"""

from __future__ import annotations

import os
import shutil
import stat
import unicodedata
import zipfile
import zlib
from pathlib import Path, PurePosixPath

from grader.batch.records import BatchError
from grader.intake.archives import AUTHORS, CODE, CXX_CODE, MAX_ARCHIVE_BYTES, zip_time
from grader.intake.records import Refusal

ARCHIVES = (".zip", ".tar.gz", ".tgz", ".tar")
MAX_ENTRIES = 100_000
MAX_TOTAL_BYTES = 4_000_000_000  # of what is written
MAX_PART = 200  # bytes of a file's name
_UTF8_FLAG = 0x800
_BLOCK = 1 << 20


def unpack(archive: Path, folder: Path) -> dict[str, list[Refusal]]:
    """Write the entries of an archive below a folder; return the refused ones by their first part.

    A folder is made for each first part, even when nothing in it can be graded. Raises BatchError.
    """
    refused: dict[str, list[Refusal]] = {}
    left = MAX_TOTAL_BYTES
    try:
        with zipfile.ZipFile(archive) as opened:
            entries = opened.infolist()
            if len(entries) > MAX_ENTRIES:
                raise BatchError("batch.too_many", path=archive, count=MAX_ENTRIES)
            for each in entries:
                place, problem = _place(each)
                if not problem and not each.is_dir() and is_wanted(place):
                    size, problem = _write(opened, each, folder / place, left)
                    left -= size
                if problem:
                    refused.setdefault(place.parts[0], []).append(Refusal(str(place), problem))
                elif len(place.parts) > 1 or each.is_dir():
                    (folder / place.parts[0]).mkdir(parents=True, exist_ok=True)
    except (zipfile.BadZipFile, zlib.error, EOFError, ValueError, NotImplementedError) as error:
        raise BatchError("batch.broken", path=archive, error=error) from error
    return refused


def is_archive(path: PurePosixPath | Path) -> bool:
    """Say whether a file's name is that of an archive."""
    return path.name.lower().endswith(ARCHIVES)


def is_wanted(path: PurePosixPath | Path) -> bool:
    """Say whether a file may be graded, or hold what may be."""
    known = path.suffix in (*CODE, *CXX_CODE) or path.name.lower().endswith(AUTHORS)
    return (known or is_archive(path)) and not path.name.startswith(".")


def names(archive: Path) -> list[str]:
    """Return the names of the entries of an archive; none when it is no .zip."""
    try:
        with zipfile.ZipFile(archive) as opened:
            return [_name(each) for each in opened.infolist()[:MAX_ENTRIES]]
    except (OSError, zipfile.BadZipFile, ValueError, NotImplementedError):
        return []


def _name(entry: zipfile.ZipInfo) -> str:
    """Return an entry's name; many tools write UTF-8 without saying so."""
    name = entry.filename
    if not entry.flag_bits & _UTF8_FLAG:
        try:
            name = name.encode("cp437").decode("utf-8")
        except UnicodeError:
            name = entry.filename
    return unicodedata.normalize("NFC", name.replace("\\", "/"))


def _place(entry: zipfile.ZipInfo) -> tuple[PurePosixPath, str]:
    """Return where an entry goes, or why it goes nowhere: a key of [refused] in messages/."""
    path = PurePosixPath(_name(entry) or "?")
    if path.is_absolute() or ".." in path.parts or not path.parts:
        safe = [each for each in path.parts if each not in ("/", "..")]
        return PurePosixPath(*(safe or ["?"])), "outside"
    kind = stat.S_IFMT(entry.external_attr >> 16)
    if kind not in (0, stat.S_IFREG, stat.S_IFDIR):
        return path, "link" if kind == stat.S_IFLNK else "special"
    if any(len(os.fsencode(each)) > MAX_PART or not each.isprintable() for each in path.parts):
        return path, "name"
    return path, "locked" if entry.flag_bits & 1 else ""


def _write(
    opened: zipfile.ZipFile, entry: zipfile.ZipInfo, path: Path, left: int
) -> tuple[int, str]:
    """Write an entry's content; return its size, or why it is refused. Raises OSError."""
    most = min(MAX_ARCHIVE_BYTES, left)
    if entry.file_size > most:
        return 0, "huge"
    if path.exists():
        return 0, "twice"
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        with opened.open(entry) as source, path.open("xb") as target:
            shutil.copyfileobj(source, target, _BLOCK)
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError):
        path.unlink(missing_ok=True)
        return 0, "damaged"
    moment = zip_time(entry)
    os.utime(path, (moment, moment))
    return entry.file_size, ""
