"""What a folder, a .zip or a .tar.gz holds, and the content of the files that are asked for.

    listed = list(entries(path))                     # names, sizes, dates: no content
    files = contents(path, [each.path for each in listed if ...])

Nothing is ever unpacked: entries are listed within bounds, then only the files that are asked for
are read, into memory. What is unsafe is left out one entry at a time, with the reason. Every name,
date and number of an archive is somebody's claim, and is made sane before it goes any further.
"""

from __future__ import annotations

import gzip
import math
import os
import stat
import struct
import tarfile
import time
import unicodedata
import zipfile
import zlib
from collections.abc import Callable, Collection, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path, PurePosixPath

from grader.course.message import UserError
from grader.intake import tar_stream
from grader.intake.file_names import original

MAX_FILE_BYTES = 1_000_000
MAX_ENTRIES = 10_000  # files and folders looked at, C or not
MAX_DEPTH = 12  # folders in folders
MAX_ARCHIVE_BYTES = 100_000_000  # as it is sent
MAX_DIRECTORY_BYTES = 5_000_000  # the list of a .zip, read whole
LATEST = 253_402_214_400.0  # the last day that a calendar of four digits can tell

CODE = (".c", ".h")
CXX_CODE = (".cpp", ".cc", ".cxx", ".hpp")
AUTHORS = "auteurs.txt"  # in small letters
# Made by tools and systems: never a student's sources.
_IGNORED = ("__MACOSX", "__pycache__", "node_modules", "build")
# What the libraries raise, in one version of Python or another, at bytes that make no sense.
_DAMAGE = (
    *(zipfile.BadZipFile, tarfile.TarError, zlib.error, EOFError, ValueError, struct.error),
    *(NotImplementedError, OverflowError, IndexError, gzip.BadGzipFile),
)
ENDS = ("many", "unpacked", "header")  # problems behind which nothing more is looked at
# The others need libraries that take as much memory as an archive claims to need.
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_UNPRINTABLE = ("Cc", "Cf", "Cs", "Zl", "Zp")  # categories of characters
_END, _END_BYTES, _LOCATOR, _LOCATOR_BYTES = b"PK\5\6", 22, b"PK\6\7", 20

# The content of a file, or the key of its problem; "" where there is none.
Content = tuple[bytes, str]
_Read = Callable[[int], Content]


class SubmissionError(UserError):
    """The path is not a submission: wrong use."""

    code = 2


@dataclass(frozen=True)
class Entry:
    """A file to read or to tell of; `problem` is a key of [refused] in messages/, or ""."""

    path: PurePosixPath
    modified: float = 0.0  # seconds since the epoch
    size: int = 0  # as it is claimed: no more is ever read
    problem: str = ""
    other: bool = False  # neither C nor AUTEURS.txt: nothing that is judged


# What is found: the entry, and how it is read; None for a folder.
_Found = Iterator[tuple[Entry, _Read | None]]


def entries(path: Path) -> Iterator[Entry]:
    """List C files, AUTEURS.txt, what is unsafe, and the names of the others.

    Raises SubmissionError, with the cure.
    """
    seen: set[PurePosixPath] = set()
    for entry, read in _looked_at(path):
        if entry.problem in ENDS:
            yield entry
        elif read is None or any(is_ignored(part) for part in entry.path.parts if part != ".."):
            continue
        elif entry.path in seen:
            yield Entry(entry.path, problem="twice")
        elif entry.problem or is_listed(entry.path):
            seen.add(entry.path)
            yield replace(entry, problem=_problem(entry, MAX_FILE_BYTES))
        else:
            yield Entry(entry.path, other=True)


def contents(
    path: Path, wanted: Collection[PurePosixPath], most: int = MAX_FILE_BYTES
) -> dict[PurePosixPath, Content]:
    """Read files by the paths that `entries` gave them, of at most so many bytes each.

    Raises SubmissionError.
    """
    found: dict[PurePosixPath, Content] = {}
    for entry, read in _looked_at(path):
        if len(found) == len(wanted):
            break
        if read and entry.path in wanted and entry.path not in found:
            problem = _problem(entry, most)
            found[entry.path] = (b"", problem) if problem else _content(read, most)
    return found


def read_file(path: Path, most: int = MAX_FILE_BYTES) -> Content:
    """Read a regular file, never through a link; return its content, or the problem."""
    try:
        if problem := _kind(path.lstat().st_mode):
            return b"", problem
        # The file may have been replaced since: no link is followed, no pipe waited for.
        handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
        with os.fdopen(handle, "rb") as file:
            content = file.read(most + 1)
        return (b"", "large") if len(content) > most else (content, "")
    except OSError:
        return b"", "closed"


def is_ignored(name: str) -> bool:
    """Say whether a folder or a file is made by tools and systems, by its name."""
    return name.startswith(".") or name in _IGNORED


def sane_date(seconds: float) -> float:
    """Return a date that a calendar can show, in seconds since the epoch; 0 for any other."""
    return float(seconds) if math.isfinite(seconds) and 0 <= seconds < LATEST else 0.0


def zip_time(each: zipfile.ZipInfo) -> float:
    """Return when an entry was last written, in seconds since the epoch; 0 when it is no date."""
    try:
        return sane_date(time.mktime((*each.date_time, 0, 0, -1)))
    except (OverflowError, ValueError):
        return 0.0


def _problem(entry: Entry, most: int) -> str:
    return entry.problem or ("large" if entry.size > most else "")


def _content(read: _Read, most: int) -> Content:
    try:
        return read(most)
    except (*_DAMAGE, OSError):
        return b"", "damaged"


def _kind(mode: int) -> str:
    """Return the problem with a file's kind, "" when it is a plain one."""
    if stat.S_ISLNK(mode):
        return "link"
    return "" if stat.S_ISREG(mode) else "special"


def is_listed(path: PurePosixPath | Path) -> bool:
    """Say whether a file may be judged, or say who made it, by its name."""
    name = original(path.name).lower()
    return name.endswith((*CODE, *CXX_CODE)) or name == AUTHORS


def _looked_at(path: Path) -> _Found:
    """Yield what there is, up to the bound; an entry "many" says that there is more."""
    for number, (entry, read) in enumerate(_found(path)):
        if number >= MAX_ENTRIES:
            yield replace(entry, problem="many"), None
            return
        yield entry, read


def _found(path: Path) -> _Found:
    try:
        path.lstat()
        if path.is_dir():
            yield from _folder(path)
        elif not path.is_file():
            raise SubmissionError("submission.not_a_folder", path=path)
        elif path.stat().st_size > MAX_ARCHIVE_BYTES:
            raise SubmissionError("submission.too_large", path=path, mb=MAX_ARCHIVE_BYTES // 10**6)
        else:
            yield from _zip(path) if _is_zip(path) else _tar(path)
    except (FileNotFoundError, NotADirectoryError) as error:
        raise SubmissionError("submission.no_folder", path=path) from error
    except _DAMAGE as error:
        raise SubmissionError("submission.broken", path=path, error=error) from error
    except OSError as error:
        raise SubmissionError("submission.closed", path=path, error=error.strerror) from error


def _folder(top: Path) -> _Found:
    top.stat()
    with os.scandir(top):
        pass  # a closed folder is told; closed folders further down are not
    for folder, folders, files in os.walk(top):
        place = PurePosixPath(os.path.relpath(folder, top))
        deep = len(place.parts) >= MAX_DEPTH
        folders[:] = [] if deep else sorted(each for each in folders if not is_ignored(each))
        yield from ((Entry(place / each), None) for each in folders)
        for name in sorted(files):
            path = Path(folder, name)
            with suppress(OSError):
                found = path.lstat()
                problem = _kind(found.st_mode) if is_listed(PurePosixPath(name)) else ""
                entry = Entry(place / name, sane_date(found.st_mtime), found.st_size, problem)
                yield entry, partial(read_file, path)


def _named(name: str, modified: float, size: int, problem: str) -> Entry:
    """Return an archive's entry; a path that leaves the archive is a problem."""
    # Some tools of Windows write it so; what cannot be printed must not reach a terminal.
    text = "".join(
        "\ufffd" if unicodedata.category(each) in _UNPRINTABLE else each
        for each in name.replace("\\", "/")
    )
    path = PurePosixPath(text)
    if not path.parts:
        path, problem = PurePosixPath("?"), problem or "name"
    if path.is_absolute() or ".." in path.parts or ":" in path.parts[0]:
        problem = "outside"
    return Entry(path, sane_date(modified), max(size, 0), problem)


def _is_zip(path: Path) -> bool:
    """Tell a .zip by its end; refuse one whose list alone would fill the memory."""
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - 65_557))
        tail = file.read()
    at = tail.rfind(_END)
    if at < 0 or len(tail) - at < _END_BYTES:
        return False
    listing = int.from_bytes(tail[at + 12 : at + 16], "little")
    # Only archives of many files, or of gigabytes, have a second end of 64 bits.
    wide = tail[max(0, at - _LOCATOR_BYTES) : at].startswith(_LOCATOR)
    if listing > MAX_DIRECTORY_BYTES or wide:
        raise SubmissionError("submission.too_many", path=path, count=MAX_ENTRIES)
    return True


def _zip(path: Path) -> _Found:
    with zipfile.ZipFile(path) as archive:
        for each in archive.infolist():
            kind = stat.S_IFMT(each.external_attr >> 16)
            problem = _kind(kind) if kind else ""
            problem = "method" if each.compress_type not in _METHODS else problem
            problem = "locked" if each.flag_bits & 1 else problem
            is_folder = each.filename.endswith(("/", "\\"))
            entry = _named(each.filename, zip_time(each), each.file_size, problem)
            yield entry, None if is_folder else partial(_unzipped, archive, each)


def _unzipped(archive: zipfile.ZipFile, each: zipfile.ZipInfo, most: int) -> Content:
    """Unpack an entry; the library goes no further than where it claims to end."""
    with archive.open(each) as file:
        return file.read(most), ""


def _tar(path: Path) -> _Found:
    with path.open("rb") as file:
        try:
            for member, read in tar_stream.members(file):
                problem = "" if member.isreg() else "special"
                problem = "link" if member.issym() or member.islnk() else problem
                entry = _named(member.name, member.mtime, member.size, problem)
                yield entry, None if member.isdir() else read
        except tarfile.ReadError as error:
            raise SubmissionError("submission.not_an_archive", path=path) from error
        except tar_stream.TooLongError as error:
            yield Entry(PurePosixPath(path.name), problem=error.problem), None
