"""What submissions leave behind where no sandbox keeps it from them: removed, or at least counted.

Only what is certainly theirs is removed: what is new, and belongs to nobody's account, which root's
submissions run under; of who runs them under their own account, shared memory whose maker is gone.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import shutil
import stat
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from grader.sandbox.bubblewrap import NOBODY
from grader.sandbox.scratch import PREFIX

PLACES = ("/tmp", "/var/tmp", "/dev/shm")  # where everybody may write
_SYSTEM_V = {"shm": "shmid", "sem": "semid", "msg": "msqid"}
_REMOVE = 0  # IPC_RMID


def _user() -> int:
    """Return whom submissions run as."""
    return NOBODY if os.geteuid() == 0 else os.geteuid()


@dataclass
class Leftovers:
    """What there was before submissions ran, and what is new since."""

    places: tuple[str, ...] = PLACES
    _files: frozenset[Path] = field(init=False)
    _objects: frozenset[tuple[str, int]] = field(init=False)

    def __post_init__(self) -> None:
        self._files = frozenset(self._written())
        self._objects = frozenset((kind, number) for kind, number, _ in _system_v())

    def remove(self) -> None:
        """Remove what is new and certainly a submission's."""
        for kind, number, maker in _system_v():
            is_new = (kind, number) not in self._objects
            if is_new and (os.geteuid() == 0 or (maker and not Path(f"/proc/{maker}").exists())):
                _remove_object(kind, number)
        if os.geteuid() == 0:
            for path in self.files():
                with contextlib.suppress(OSError):  # it is gone
                    is_folder = stat.S_ISDIR(path.lstat().st_mode)
                    shutil.rmtree(path) if is_folder else path.unlink()

    def files(self) -> list[Path]:
        """Return the new files and folders of whom submissions run as."""
        return sorted(frozenset(self._written()) - self._files)

    def _written(self) -> Iterator[Path]:
        for place in map(Path, self.places):
            with contextlib.suppress(OSError):
                for path in place.iterdir():
                    # Root's own folders are not nobody's.
                    ours = os.geteuid() != 0 and path.name.startswith(PREFIX)
                    if path.lstat().st_uid == _user() and not ours:
                        yield path


def _system_v() -> Iterator[tuple[str, int, int]]:
    """Yield kind, number and maker (0: untold) of what is shared of whom submissions run as."""
    for kind, column in _SYSTEM_V.items():
        with contextlib.suppress(OSError, ValueError):  # a system that does not list them
            lines = Path(f"/proc/sysvipc/{kind}").read_text(encoding="ascii").splitlines()
            head = lines[0].split()
            for line in lines[1:]:
                row = dict(zip(head, map(int, line.split()), strict=False))
                if row["cuid"] == _user():
                    yield kind, row[column], row.get("cpid", 0)


def _remove_object(kind: str, number: int) -> None:
    libc = ctypes.CDLL(None)
    if kind == "sem":
        libc.semctl(number, 0, _REMOVE)
    else:
        getattr(libc, f"{kind}ctl")(number, _REMOVE, None)
