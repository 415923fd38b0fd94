"""Room on the disk, looked for before compiling: what a compiler says without it leads astray."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

from grader.course.message import UserError

NEEDED = 50_000_000  # bytes: the libraries of a submission, its results, what compilers leave


class NoRoomError(UserError):
    """A disk is full: the machine's fault."""


def require_room(folder: Path) -> None:
    """Raise NoRoomError unless there is room in a folder, and where compilers put their files."""
    for place in (_existing(folder), Path(tempfile.gettempdir())):
        free = shutil.disk_usage(place).free
        if free < NEEDED:
            megabytes = {"free": free // 10**6, "needed": NEEDED // 10**6}
            raise NoRoomError("machine.no_room", path=place, **megabytes)


def _existing(folder: Path) -> Path:
    """Return the folder, or the first above it that is there."""
    folder = folder.resolve()
    return next(each for each in (folder, *folder.parents) if each.exists())
