"""What the process that grades owes to itself, and to the machine when it ends. Linux only.

Nobody may attach to it, even a process of its own user: code that escaped its walls could otherwise
read what is expected, or stop the grader for good. And what the programs that it has run leave
behind becomes its own, to be ended with it.
"""

from __future__ import annotations

import contextlib
import os
import signal
import sys
from functools import cache
from pathlib import Path
from typing import Any

from grader.sandbox.ffi_source import lock_source
from grader.worker.lockdown import Lock

ROUNDS = 50  # an orphan's own children come in the next one


def guard() -> None:
    """Be closed to debuggers, and the parent of what children leave behind.

    For a process that does nothing but grade: a notebook's kernel, or a test's, has other duties.
    """
    if sys.platform.startswith("linux"):
        _lock().close_to_debuggers()
    adopt()


def adopt() -> None:
    """Be the parent of what children leave behind."""
    if sys.platform.startswith("linux"):
        _lock().adopt_orphans()


@cache
def _lock() -> Lock:
    names: dict[str, Any] = {}
    exec(lock_source(), names)
    return Lock(names["ffi"])


def sweep() -> None:
    """End every child that this process still has: none is its own any more."""
    for _ in range(ROUNDS):
        left = _children()
        if not left:
            return
        for pid in left:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.kill(pid, signal.SIGKILL)
            with contextlib.suppress(ChildProcessError):
                os.waitpid(pid, 0)


def _children() -> set[int]:
    """Return the processes that this one has; none where the system does not tell."""
    found: set[int] = set()
    for task in Path("/proc/self/task").glob("*/children"):
        with contextlib.suppress(OSError):  # a thread that has just ended
            found |= set(map(int, task.read_text(encoding="ascii").split()))
    return found
