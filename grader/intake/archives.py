"""The C files and AUTEURS.txt of a folder, a .zip or a .tar.gz, whatever else has been put there.

Nothing is ever unpacked: entries are listed within bounds, and only C files of a sane size are
read, into memory. What is unsafe is left out one entry at a time, with the reason.
"""

from __future__ import annotations

import gzip
import io
import os
import stat
import struct
import tarfile
import time
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from grader.course.message import UserError

MAX_FILE_BYTES = 1_000_000
MAX_ENTRIES = 10_000  # files looked at, C or not
MAX_DEPTH = 12  # folders in folders
MAX_ARCHIVE_BYTES = 100_000_000  # as it is sent
MAX_UNPACKED_BYTES = 300_000_000  # walked through in a .tar.gz, which cannot be skipped over
MAX_DIRECTORY_BYTES = 5_000_000  # the list of a .zip, read whole

CODE = (".c", ".h")
CXX_CODE = (".cpp", ".cc", ".cxx", ".hpp")
AUTHORS = "auteurs.txt"  # in small letters
# Made by tools and systems: never a student's sources.
_IGNORED = ("__MACOSX", "__pycache__", "node_modules", "build")
# What the libraries raise, in one version of Python or another, at bytes that make no sense.
_DAMAGE = (
    *(zipfile.BadZipFile, tarfile.TarError, zlib.error, EOFError, ValueError, struct.error),
    *(NotImplementedError, OverflowError),
)
_END, _END_BYTES, _LOCATOR = b"PK\5\6", 22, b"PK\6\7"


class SubmissionError(UserError):
    """The path is not a submission: wrong use."""


@dataclass(frozen=True)
class Entry:
    """A C file, AUTEURS.txt, or something unsafe; `problem` is a key of [refused], or ""."""

    path: PurePosixPath
    modified: float = 0.0  # seconds since the epoch
    content: bytes = b""
    problem: str = ""


def entries(path: Path) -> Iterator[Entry]:
    """List a folder or an archive. Raises SubmissionError, with the cure."""
    try:
        path.lstat()
        if path.is_dir():
            yield from _folder(path)
        elif not path.is_file():
            raise SubmissionError("submission.not_a_folder", path=path)
        elif path.stat().st_size > MAX_ARCHIVE_BYTES:
            raise SubmissionError("submission.too_large", path=path, mb=MAX_ARCHIVE_BYTES // 10**6)
        else:
            yield from _archive(path)
    except (FileNotFoundError, NotADirectoryError) as error:
        raise SubmissionError("submission.no_folder", path=path) from error
    except OSError as error:
        raise SubmissionError("submission.closed", path=path, error=error.strerror) from error


def read_file(path: Path) -> tuple[bytes, str]:
    """Read a regular file, never through a link; return its content, or the problem."""
    try:
        status = path.lstat()
        if not stat.S_ISREG(status.st_mode):
            return b"", "link" if stat.S_ISLNK(status.st_mode) else "special"
        # The file may have been replaced since: no link is followed, no pipe waited for.
        handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
        with os.fdopen(handle, "rb") as file:
            return _bounded(file.read(MAX_FILE_BYTES + 1))
    except OSError:
        return b"", "closed"


def _bounded(content: bytes) -> tuple[bytes, str]:
    return (b"", "large") if len(content) > MAX_FILE_BYTES else (content, "")


def _folder(top: Path) -> Iterator[Entry]:
    seen = 0
    top.stat()
    with os.scandir(top):
        pass  # a closed folder is told; closed folders further down are not
    for folder, folders, files in os.walk(top):
        place = PurePosixPath(os.path.relpath(folder, top))
        deep = len(place.parts) >= MAX_DEPTH
        folders[:] = [] if deep else sorted(each for each in folders if not is_ignored(each))
        for name in sorted(files):
            seen += 1
            if seen > MAX_ENTRIES:
                yield Entry(place, problem="many")
                return
            if _is_listed(PurePosixPath(name)) and not name.startswith("."):
                path = Path(folder, name)
                content, problem = read_file(path)
                with suppress(OSError):
                    yield Entry(place / name, path.lstat().st_mtime, content, problem)


def _is_read(path: PurePosixPath) -> bool:
    return path.suffix in CODE or path.name.lower() == AUTHORS


def _is_listed(path: PurePosixPath) -> bool:
    return path.suffix in CXX_CODE or _is_read(path)


def is_ignored(folder: str) -> bool:
    """Say whether a folder is made by tools and systems, by its name."""
    return folder.startswith(".") or folder in _IGNORED


def _archive(path: Path) -> Iterator[Entry]:
    seen: set[PurePosixPath] = set()
    try:
        for number, entry in enumerate(_zip(path) if _is_zip(path) else _tar(path)):
            if number >= MAX_ENTRIES:
                yield Entry(entry.path, problem="many")
                return
            if any(is_ignored(part) for part in entry.path.parts if part != ".."):
                continue
            if entry.path in seen:
                yield Entry(entry.path, problem="twice")
            elif entry.problem or _is_listed(entry.path):
                seen.add(entry.path)
                yield entry
    except _DAMAGE as error:
        raise SubmissionError("submission.broken", path=path, error=error) from error


def _named(name: str, modified: float, problem: str) -> Entry:
    """Return an entry without its content; a path that leaves the archive is a problem."""
    path = PurePosixPath(name.replace("\\", "/") or "?")  # some tools of Windows write it so
    if path.is_absolute() or ".." in path.parts or ":" in path.parts[0]:
        problem = "outside"
    return Entry(path, modified, problem=problem)


def _is_zip(path: Path) -> bool:
    """Tell a .zip by its end; refuse one whose list alone would fill the memory."""
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - 65_557))
        tail = file.read()
    at = tail.rfind(_END)
    if at < 0 or len(tail) - at < _END_BYTES:
        return False
    listing = int.from_bytes(tail[at + 12 : at + 16], "little")
    if listing > MAX_DIRECTORY_BYTES or tail[:at].rfind(_LOCATOR) >= 0:
        raise SubmissionError("submission.too_many", path=path, count=MAX_ENTRIES)
    return True


def _zip(path: Path) -> Iterator[Entry]:
    with zipfile.ZipFile(path) as archive:
        for each in archive.infolist():
            if each.is_dir():
                continue
            kind = stat.S_IFMT(each.external_attr >> 16)
            problem = "link" if kind == stat.S_IFLNK else ""
            problem = "special" if kind not in (0, stat.S_IFREG, stat.S_IFLNK) else problem
            problem = "locked" if each.flag_bits & 1 else problem
            entry = _named(each.filename, zip_time(each), problem)
            if entry.problem or not _is_read(entry.path):
                yield entry
                continue
            content, problem = _zip_content(archive, each)
            yield Entry(entry.path, entry.modified, content, problem)


def _zip_content(archive: zipfile.ZipFile, each: zipfile.ZipInfo) -> tuple[bytes, str]:
    """Unpack no more than what is taken, whatever size the entry claims."""
    try:
        with archive.open(each) as file:
            return _bounded(file.read(MAX_FILE_BYTES + 1))
    except _DAMAGE:
        return b"", "damaged"


def zip_time(each: zipfile.ZipInfo) -> float:
    """Return when an entry was last written, in seconds since the epoch; 0 when it is no date."""
    try:
        return time.mktime((*each.date_time, 0, 0, -1))
    except (OverflowError, ValueError):
        return 0.0


def _tar(path: Path) -> Iterator[Entry]:
    with path.open("rb") as file:
        packed = file.read(2) == b"\x1f\x8b"
        file.seek(0)
        stream = _Bounded(gzip.GzipFile(fileobj=file) if packed else file)
        try:
            # As a stream: headers too are read within the bound.
            with tarfile.open(fileobj=stream, mode="r|") as archive:
                yield from _members(archive)
        except tarfile.ReadError as error:
            raise SubmissionError("submission.not_an_archive", path=path) from error
        except _TooLongError as error:
            raise SubmissionError("submission.too_large", path=path, mb=error.args[0]) from error


def _members(archive: tarfile.TarFile) -> Iterator[Entry]:
    for each in archive:
        if each.isdir():
            continue
        problem = "" if each.isreg() else "link" if each.issym() or each.islnk() else "special"
        entry = _named(each.name, each.mtime, problem)
        if entry.problem or not _is_read(entry.path):
            yield entry
            continue
        file = archive.extractfile(each)
        content, problem = _bounded(file.read(MAX_FILE_BYTES + 1)) if file else (b"", "damaged")
        yield Entry(entry.path, entry.modified, content, problem)


class _TooLongError(Exception):
    """More bytes come out of an archive than are walked through."""


class _Bounded(io.RawIOBase):
    """A stream that gives up after a number of bytes: a small archive can hold terabytes."""

    def __init__(self, stream: io.BufferedIOBase | gzip.GzipFile) -> None:
        self._stream, self._left = stream, MAX_UNPACKED_BYTES

    def read(self, size: int = -1) -> bytes:
        """Return the next bytes, at most `size`."""
        content = self._stream.read(size)
        self._left -= len(content)
        if self._left < 0:
            raise _TooLongError(MAX_UNPACKED_BYTES // 10**6)
        return content
