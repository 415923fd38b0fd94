"""The levels of isolation, and which of them this machine can give.

strong    bubblewrap (namespaces, a minimal read-only tree), rlimits, seccomp, Landlock
medium    the same without bubblewrap
portable  rlimits, a session and a time limit of its own: against accidents, not against malice
"""

from __future__ import annotations

import contextlib
import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from functools import cache

from grader.course.message import UserError
from grader.course.texts import Texts
from grader.sandbox import bubblewrap, surroundings
from grader.worker.syscalls import ARCHITECTURES

TRIAL_SECONDS = 20


class Level(str, Enum):
    """How well a submission's code is shut in."""

    STRONG = "strong"
    MEDIUM = "medium"
    PORTABLE = "portable"


_STRONGEST_FIRST = (Level.STRONG, Level.MEDIUM, Level.PORTABLE)


@dataclass(frozen=True)
class Isolation:
    """A level, and the key of the sentence that says why it is not a better one ("" for strong)."""

    level: Level
    reason: str = ""
    detail: str = ""


class IsolationError(UserError):
    """The machine cannot give the level that was asked for; `best` has the reason and its mend."""

    def __init__(self, wanted: Level, found: Isolation) -> None:
        super().__init__("isolation.refused", wanted=wanted.value)
        self.best = found

    def sentence(self, texts: Texts) -> str:
        """Return what to tell the person at the terminal."""
        reason = texts.say(self.best.reason, detail=self.best.detail)
        return texts.say(self.key, reason=reason, **self.values)


_forced: list[Isolation] = []


def current() -> Isolation:
    """Return the isolation in which this process compiles and runs submissions."""
    return _forced[-1] if _forced else best()


@contextlib.contextmanager
def using(level: Level) -> Iterator[Isolation]:
    """Compile and run at that level until the block ends; weaker than possible if so asked.

    Raises IsolationError when the machine cannot give it.
    """
    found = best()
    if _STRONGEST_FIRST.index(found.level) > _STRONGEST_FIRST.index(level):
        raise IsolationError(level, found)
    _forced.append(Isolation(level, "isolation.asked" if level is not found.level else ""))
    try:
        yield _forced[-1]
    finally:
        _forced.pop()


@cache
def best() -> Isolation:
    """Return the best level that this machine can give, found by trying."""
    if not sys.platform.startswith("linux"):
        return Isolation(Level.PORTABLE, "isolation.not_linux")
    if platform.machine() not in ARCHITECTURES:
        return Isolation(Level.PORTABLE, "isolation.architecture", platform.machine())
    if os.geteuid() == 0 and shutil.which("setpriv") is None:
        return Isolation(Level.PORTABLE, "isolation.no_setpriv")
    if shutil.which("bwrap") is None:
        return Isolation(Level.MEDIUM, "isolation.no_bwrap")
    command = bubblewrap.sandbox([], [], {}, ["/usr/bin/env", "true"])
    try:
        done = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            env=surroundings.of_a_question(),
            errors="replace",
            timeout=TRIAL_SECONDS,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        return Isolation(Level.MEDIUM, "isolation.bwrap_fails", str(error))
    if done.returncode != 0:
        return Isolation(Level.MEDIUM, "isolation.bwrap_fails", done.stderr.strip()[:200])
    return Isolation(Level.STRONG)
