"""Folders of temporary files that end with their process: what a killed one left, the next removes.

Each holds a file that its process keeps locked; the system drops the lock whatever the end.
"""

from __future__ import annotations

import atexit
import contextlib
import fcntl
import os
import shutil
import stat
import tempfile
from collections.abc import Iterator
from pathlib import Path

PREFIX = "mrt-run-"
_LOCK = ".lock"


def use() -> None:
    """Have this process make its temporary files in a folder of its own, where that can be."""
    with contextlib.suppress(OSError):  # who needs a temporary file will say what is wrong
        tempfile.tempdir = str(own_folder())


def own_folder() -> Path:
    """Make a folder for this process and those that it starts, where temporary files are.

    A user whom root becomes can go through it. Raises OSError.
    """
    for each in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
        _remove_left(each)
    folder = Path(tempfile.mkdtemp(prefix=PREFIX))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    part = folder / f"{_LOCK}.part"
    lock = os.open(part, os.O_WRONLY | os.O_CREAT, 0o600)  # open as long as the process lives
    with contextlib.suppress(OSError):  # no locks on that file system: nobody else removes it
        fcntl.flock(lock, fcntl.LOCK_EX)
        part.rename(folder / _LOCK)  # nobody ever finds it without its lock
    folder.chmod(0o711)
    return folder


def _remove_left(folder: Path) -> None:
    """Remove a folder of ours whose process is gone."""
    with contextlib.suppress(OSError):  # it is in use, somebody else's, or being removed
        found = folder.lstat()
        if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.geteuid():
            return
        with (folder / _LOCK).open("r", encoding="ascii") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            shutil.rmtree(folder)


@contextlib.contextmanager
def files_in(folder: Path) -> Iterator[None]:
    """Have this process make its temporary files there."""
    before, tempfile.tempdir = tempfile.tempdir, str(folder)
    try:
        yield
    finally:
        tempfile.tempdir = before
