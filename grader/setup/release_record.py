"""What is handed out: an archive of a workbook, with a record of every file in it.

The record, grader/release.json, tells a later update which files a student has changed. Standard
library only, as `update` reads it: an update half-way must find nothing else that it needs.
"""

from __future__ import annotations

import hashlib
import json
import stat
import time
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from grader.setup.sentences import say

TOP = "miniraytracer"  # the folder inside the archive
RECORD = "grader/release.json"
ORIGINALS = "grader/intake/originals.zip"  # what core_c/ held
SCHEMA = 1
MAX_FILES = 5_000
MAX_BYTES = 200_000_000  # of all files, unpacked


class HandoutError(Exception):
    """What is wrong with an archive or a folder, and the cure: one line for the person."""


@dataclass(frozen=True)
class Release:
    """The record of a release: `files` gives the sha256 of each path, `own` are the student's."""

    version: str
    date: int  # seconds since the epoch, of the sources; 0 when not known
    own: tuple[str, ...]
    files: Mapping[str, str]

    @property
    def age(self) -> tuple[tuple[int, ...], int]:
        """What a later release has more of."""
        return tuple(map(int, self.version.split("."))), self.date

    @property
    def title(self) -> str:
        """The version, and the day when it is known."""
        day = time.strftime(" (%Y-%m-%d)", time.gmtime(self.date)) if self.date else ""
        return f"{self.version}{day}"

    def as_json(self) -> bytes:
        """Return the content of the record's file: the same bytes for the same release."""
        content = {
            "project": TOP,
            "schema": SCHEMA,
            "version": self.version,
            "date": self.date,
            "own": sorted(self.own),
            "files": dict(sorted(self.files.items())),
        }
        return (json.dumps(content, indent=1) + "\n").encode()


def digest(content: bytes) -> str:
    """Return the sha256 of a file's content, as the record has it."""
    return hashlib.sha256(content).hexdigest()


def parse(content: bytes) -> Release:
    """Read a record. Raises ValueError."""
    try:
        table = json.loads(content)
        if (table["project"], table["schema"]) != (TOP, SCHEMA):
            raise ValueError("another project, or another time")
        release = Release(
            table["version"], int(table["date"]), tuple(table["own"]), dict(table["files"])
        )
        if not (release.age and 0 <= release.date < 2**33):
            raise ValueError("date")
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"{error}") from error
    for path in (*release.own, *release.files):
        if not _is_safe(path):
            raise ValueError(path)
    return release


def read(path: Path) -> tuple[Release, dict[str, bytes]]:
    """Return the record and the files of an archive, or of the folder that it was unpacked to.

    Every file is compared with the record. Raises HandoutError.
    """
    try:
        files = _from_folder(path) if path.is_dir() else _from_zip(path)
        release = parse(files.pop(RECORD))
    except FileNotFoundError as error:
        raise _not_found(path) from error
    except KeyError as error:
        raise _not_ours(path) from error
    except OSError as error:
        raise HandoutError(say("setup.archive_unread", path=path, error=error.strerror)) from error
    # What zipfile raises, in one version or another, at bytes that make no sense.
    except (zipfile.BadZipFile, zlib.error, EOFError, ValueError, NotImplementedError) as error:
        raise _damaged(path, str(error)) from error
    wrong = {name for name in release.files if digest(files.get(name, b"")) != release.files[name]}
    if odd := sorted(wrong | (set(files) - set(release.files))):
        raise _damaged(path, odd[0])
    return release, files


def _is_safe(name: str) -> bool:
    """Whether a path stays where it is unpacked, on every system."""
    return (
        isinstance(name, str)
        and bool(name)
        and not set('\\:*?"<>|\0') & set(name)
        and name == str(PurePosixPath(name))
        and not name.startswith("/")
        and not {"..", "."} & set(name.split("/"))
    )


def _from_zip(path: Path) -> dict[str, bytes]:
    """Read every entry. Raises ValueError for one that is not safe, KeyError when none is ours."""
    found: dict[str, bytes] = {}
    with zipfile.ZipFile(path) as archive:
        entries = [each for each in archive.infolist() if not each.is_dir()]
        if len(entries) > MAX_FILES or sum(each.file_size for each in entries) > MAX_BYTES:
            raise ValueError(say("setup.too_many_files"))
        if f"{TOP}/{RECORD}" not in archive.namelist():
            raise KeyError(RECORD)
        for each in entries:
            name = each.filename.removeprefix(f"{TOP}/")
            regular = stat.S_IFMT(each.external_attr >> 16) in (0, stat.S_IFREG)
            safe = name != each.filename and _is_safe(name) and name not in found
            if not (safe and regular) or each.flag_bits & 1:
                raise ValueError(each.filename)
            found[name] = archive.read(each)
    return found


def _from_folder(folder: Path) -> dict[str, bytes]:
    """Read the files that the folder's record names: some browsers unpack what they download."""
    top = folder / TOP if (folder / TOP / RECORD).is_file() else folder
    if not (top / RECORD).is_file():
        raise KeyError(RECORD)
    record = (top / RECORD).read_bytes()
    names = [name for name in parse(record).files if (top / name).is_file()]
    return {RECORD: record, **{name: (top / name).read_bytes() for name in names}}


def _not_found(path: Path) -> HandoutError:
    return HandoutError(say("setup.no_archive", path=path))


def _not_ours(path: Path) -> HandoutError:
    return HandoutError(say("setup.not_ours", path=path))


def _damaged(path: Path, detail: str) -> HandoutError:
    return HandoutError(say("setup.archive_damaged", path=path, detail=detail))
