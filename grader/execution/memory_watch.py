"""Ends a session that takes more memory than it may.

The limit of addresses (RLIMIT_AS) does not bound memory under AddressSanitizer, which reserves
terabytes of them before the submission's code is there. A thread of this process looks at what the
sessions of its workers really occupy, those that are made ready or are ending among them.
"""

from __future__ import annotations

import contextlib
import mmap
import os
import signal
import threading
import time
from pathlib import Path

LOOK_SECONDS = 0.02  # in which a process takes some 40 MB

_watched: list[MemoryWatch] = []
_changing = threading.Condition()
_threads: list[threading.Thread] = []


class MemoryWatch:
    """A worker, each of whose children may occupy so many bytes more than it does itself."""

    def __init__(self, worker: int, more: int) -> None:
        self._worker, self._more = worker, more
        self._ended: set[int] = set()

    def start(self) -> None:
        """Look from now on."""
        with _changing:
            _watched.append(self)
            if not _threads:
                _threads.append(threading.Thread(target=_look, daemon=True))
                _threads[0].start()
            _changing.notify()

    def stop(self) -> None:
        """Look no longer."""
        with _changing, contextlib.suppress(ValueError):
            _watched.remove(self)

    def has_ended(self, session: int) -> bool:
        """Say whether that process was ended for its memory."""
        return session in self._ended

    def look(self) -> None:
        """End the children that occupy too much."""
        most = _occupied(self._worker) + self._more
        for child in _children(self._worker):
            if _occupied(child) > most:
                self._ended.add(child)
                with contextlib.suppress(OSError):  # it has just ended
                    os.kill(child, signal.SIGKILL)


def _look() -> None:
    while True:
        with _changing:
            while not _watched:
                _changing.wait()
            for each in _watched:
                each.look()
        time.sleep(LOOK_SECONDS)


def _children(pid: int) -> list[int]:
    try:
        text = Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="ascii")
    except OSError:  # it has ended, or the system does not tell
        return []
    return [int(each) for each in text.split()]


def _occupied(pid: int) -> int:
    """Return the bytes of memory that a process occupies; 0 when it has ended."""
    try:
        text = Path(f"/proc/{pid}/statm").read_text(encoding="ascii")
        return int(text.split()[1]) * mmap.PAGESIZE
    except (OSError, IndexError):
        return 0
