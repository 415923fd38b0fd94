"""Writing files that others may read at the same time, and names that stand for a content."""

from __future__ import annotations

import hashlib
import os
import tempfile
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


def content_key(*parts: object) -> str:
    """Return a name for files that stands for the content of its arguments."""
    return hashlib.sha256(repr(parts).encode(errors="surrogateescape")).hexdigest()[:24]
