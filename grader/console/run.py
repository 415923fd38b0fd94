"""How a command ends: its exit code, and what went wrong as one line on stderr."""

from __future__ import annotations

import sys
from collections.abc import Callable
from enum import IntEnum

from grader.course.message import GraderError
from grader.course.texts import Texts
from grader.setup.folding import put


class ExitCode(IntEnum):
    """The exit codes of every command."""

    DONE = 0
    BELOW = 1  # graded, below --fail-under
    WRONG_USE = 2
    FAILED = 3  # the grader or the machine
    INTERRUPTED = 130


def run(act: Callable[[], int], texts: Texts) -> int:
    """Run a command; return its exit code."""
    try:
        return act()
    except GraderError as error:
        return complain(error.sentence(texts), error.code)
    except KeyboardInterrupt:
        return ExitCode.INTERRUPTED


def told(error: GraderError | OSError, texts: Texts) -> str:
    """Return an error as a line to read: the machine's own words where it is no error of ours."""
    return error.sentence(texts) if isinstance(error, GraderError) else str(error)


def complain(sentence: str, code: int) -> int:
    """Say what is wrong; return the exit code."""
    put(sentence, sys.stderr)
    return code
