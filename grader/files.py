"""Writing files that others may read at the same time, and what stands for a content."""

from __future__ import annotations

import contextlib
import hashlib
import io
import os
import tempfile
import zipfile
from collections.abc import Collection, Mapping
from errno import ENOTDIR
from pathlib import Path


def write_whole(path: Path, content: bytes | str) -> None:
    """Write a file whole: others see the old one, or the new one. Makes its folder.

    A text is in UTF-8, with its own ends of lines. Raises OSError, and leaves nothing behind.
    """
    if isinstance(content, str):
        content = content.encode("utf-8", errors="replace")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except FileExistsError as error:  # a file stands there
        raise NotADirectoryError(ENOTDIR, os.strerror(ENOTDIR), str(path.parent)) from error
    handle, part = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name[:100]}.", suffix=".part")
    try:
        with os.fdopen(handle, "wb") as out:
            out.write(content)
        os.chmod(part, 0o644)
        os.replace(part, path)
    except BaseException:
        Path(part).unlink(missing_ok=True)
        raise


def closed_folder(path: Path) -> None:
    """Make a folder, if need be, that no other user of the machine can enter. Raises OSError."""
    path.mkdir(parents=True, exist_ok=True)
    if path.stat().st_uid == os.geteuid():
        path.chmod(0o700)


def zipped(
    files: Mapping[str, bytes],
    date: tuple[int, int, int, int, int, int] = (1980, 1, 1, 0, 0, 0),
    compression: int = zipfile.ZIP_DEFLATED,
    executable: Collection[str] = (),
) -> bytes:
    """Return a .zip of files by their paths, sorted: the same bytes for the same content.

    `executable` are the paths of those that can be executed. ZIP has no date before 1980.
    """
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        for path, content in sorted(files.items()):
            entry = zipfile.ZipInfo(path, date)
            mode = 0o100755 if path in executable else 0o100644
            entry.create_system, entry.external_attr = 3, mode << 16
            archive.writestr(entry, content, compression)
    return out.getvalue()


Marks = tuple[tuple[str, int, int], ...]  # of files: name, date, size


def marks(folder: Path) -> Marks:
    """Return what changes when a C file of the folder is saved; nothing without a folder."""
    found = []
    with contextlib.suppress(OSError), os.scandir(folder) as entries:
        for each in entries:
            if each.name.endswith((".c", ".h")):
                with contextlib.suppress(OSError):  # being replaced
                    state = each.stat()
                    found.append((each.name, state.st_mtime_ns, state.st_size))
    return tuple(sorted(found))


def content_key(*parts: object) -> str:
    """Return a name for files that stands for the content of its arguments."""
    return hashlib.sha256(repr(parts).encode(errors="surrogateescape")).hexdigest()[:24]
