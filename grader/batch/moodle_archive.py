"""A Moodle "download all submissions" archive, taken apart: what may be graded, and no more.

Entries are written under names of our own making, one by one; an unsafe one is refused and the rest
goes on.
"""

from __future__ import annotations

import os
import re
import shutil
import stat
import unicodedata
import zipfile
import zlib
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

from grader.batch.records import BatchError
from grader.intake.archives import MAX_ARCHIVE_BYTES, MAX_FILE_BYTES, is_listed, zip_time
from grader.intake.records import Refusal

# The name of a participant's or a group's folder; without folders each file's name begins so.
FOLDER = re.compile(
    r"(?P<label>.+?)(?:_(?P<number>\d+))?_assignsubmission_(?P<plugin>[a-z]+)(?:_(?P<rest>.*))?"
)
ARCHIVES = (".zip", ".tar.gz", ".tgz", ".tar")
MAX_ENTRIES = 100_000
MAX_FILES = 10_000  # of one participant
MAX_PART = 200  # bytes of a file's name
_SYSTEM = (".DS_Store", "Thumbs.db", "desktop.ini")
_UTF8_FLAG = 0x800
_BLOCK = 1 << 20


@dataclass
class Left:
    """What of an archive was not written, by the first part of its path."""

    refused: dict[str, list[Refusal]] = field(default_factory=dict)
    unread: dict[str, list[str]] = field(default_factory=dict)


def unpack(archive: Path, folder: Path) -> Left:
    """Write the entries of an archive that may be graded below a folder; return the others.

    A folder is made for each first part, even when nothing in it can be graded. Raises BatchError.
    """
    unpacked = _Unpacked(folder)
    try:
        with zipfile.ZipFile(archive) as opened:
            entries = opened.infolist()
            if len(entries) > MAX_ENTRIES:
                raise BatchError("batch.too_many", path=archive, count=MAX_ENTRIES)
            for each in entries:
                unpacked.take(opened, each)
    except (zipfile.BadZipFile, zlib.error, EOFError, ValueError, NotImplementedError) as error:
        raise BatchError("batch.broken", path=archive, error=error) from error
    return unpacked.left


@dataclass
class _Unpacked:
    """A folder that is being filled from an archive."""

    folder: Path
    left: Left = field(default_factory=Left)
    # Of each participant: nobody's files take the room of another's.
    sizes: Counter[str] = field(default_factory=Counter)
    counts: Counter[str] = field(default_factory=Counter)

    def take(self, opened: zipfile.ZipFile, entry: zipfile.ZipInfo) -> None:
        """Write an entry, or note why not. Raises OSError."""
        place, problem = _place(entry)
        if is_system(place):
            return
        top = place.parts[0]
        wanted = is_wanted(place) and not entry.is_dir()
        if not problem and wanted:
            problem = self._write(opened, entry, place)
        if problem:
            self.left.refused.setdefault(top, []).append(Refusal(str(place), problem))
            return
        if not wanted and not entry.is_dir():
            self.left.unread.setdefault(top, []).append(str(place.relative_to(top)))
        if len(place.parts) > 1 or entry.is_dir():
            (self.folder / top).mkdir(parents=True, exist_ok=True)

    def _write(self, opened: zipfile.ZipFile, entry: zipfile.ZipInfo, place: PurePosixPath) -> str:
        """Write an entry within its participant's budget; return why it is refused, or ""."""
        who = participant(place)
        if self.counts[who] >= MAX_FILES:
            return "many"
        if not is_archive(place) and entry.file_size > MAX_FILE_BYTES:
            return "large"
        size, problem = _write(
            opened, entry, self.folder / place, MAX_ARCHIVE_BYTES - self.sizes[who]
        )
        self.sizes[who] += size
        self.counts[who] += not problem
        return problem


def participant(place: PurePosixPath) -> str:
    """Return whose an entry is: all of a participant's bear one name, in folders or without."""
    top = place.parts[0]
    found = FOLDER.fullmatch(top)
    return f"{found['label']}_{found['number']}" if found else top


def is_system(path: PurePosixPath | Path) -> bool:
    """Say whether a path is one that systems make for themselves, and nobody's."""
    return "__MACOSX" in path.parts or path.name in _SYSTEM or path.name.startswith("._")


def is_archive(path: PurePosixPath | Path) -> bool:
    """Say whether a file's name is that of an archive."""
    return path.name.lower().endswith(ARCHIVES)


def is_wanted(path: PurePosixPath | Path) -> bool:
    """Say whether a file may be graded, or hold what may be."""
    if (found := FOLDER.fullmatch(path.name)) and found["rest"]:
        path = path.with_name(found["rest"])
    return (is_listed(path) or is_archive(path)) and not path.name.startswith(".")


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
    opened: zipfile.ZipFile, entry: zipfile.ZipInfo, path: Path, most: int
) -> tuple[int, str]:
    """Write an entry's content; return its size, or why it is refused. Raises OSError."""
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
