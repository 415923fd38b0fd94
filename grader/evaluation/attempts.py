"""Running one check: first in a process that serves several, again where that is not enough.

Right programs take one process for all their functions. What fails there, for whatever reason, is
made again in a process of its own, which alone counts; so is what else that exercise is checked by.

The archive holds the inputs that functions are judged on, and the answers to them: a program that
has these by heart is right there, and wrong on any others.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from grader.checking.student import CallDied, Student, Wrong
from grader.evaluation.outcomes import was_killed
from grader.execution.records import OUT_OF_TIME
from grader.execution.worker_process import Died, MachineError

# How often a check is run whose process is killed each time; and how often in all for that reason.
TRIES = 3
RERUNS = 6

Act = Callable[[Student], None]  # what a check does


@dataclass(frozen=True)
class Attempt:
    """What a check has raised, if anything, and the submission as it has left it.

    `unseen`: it was right on the inputs of the archive, and this was raised on others.
    """

    student: Student
    error: Exception | None
    unseen: bool = False


class Attempts:
    """How the checks of one run are made; `fresh` is a folder of inputs that nobody has seen."""

    def __init__(self, fresh: Path | None = None) -> None:
        self._fresh = fresh
        self._reruns = RERUNS
        self._apart: set[tuple[str, ...]] = set()  # functions of which a check has failed
        self._out_of_memory = out_of_memory()

    def made(self, act: Act, student: Student) -> Attempt:
        """Run a check; where it earns something and has such inputs, on these too.

        A picture of which a part is right has to be as good there, roughly.
        """
        first = self._tried(act, student)
        if self._fresh is None or not first.student.has_inputs or not _earned(first):
            return first
        other = self._tried(act, student.with_inputs(self._fresh))
        if not other.error or (first.error and _earned(other) > _earned(first) / 2):
            return first
        return Attempt(other.student, other.error, unseen=True)

    def _tried(self, act: Act, student: Student) -> Attempt:
        """Run a check; again when its process was killed, which may have been done from outside.

        What kills itself does so each time. It is no fault of its own where memory runs out.
        """
        if (lent := self._lent(act, student)) is not None:
            return lent
        error = _raised(act, student)
        for _ in range(TRIES - 1):
            if not was_killed(error):
                return Attempt(student, error)
            if not self._reruns:
                break
            self._reruns -= 1
            student = student.anew()
            error = _raised(act, student)
        if was_killed(error) and out_of_memory() != self._out_of_memory:
            error = MachineError("the machine is short of memory, and kills processes")
        return Attempt(student, error)

    def _lent(self, act: Act, student: Student) -> Attempt | None:
        """Run a check in a process that serves several; None when that does not count."""
        lent = student.lent() if student.own not in self._apart else None
        if lent is None:
            return None
        error = _raised(act, lent)
        if error is None or not lent.is_begun or _has_run_out(error):
            return Attempt(lent, error)
        self._apart.add(student.own)
        return None


def _has_run_out(error: Exception) -> bool:
    """Say whether a check ended because its time was over: it would only be so again."""
    return isinstance(error, CallDied | Died) and error.death.cause in OUT_OF_TIME


def _earned(attempt: Attempt) -> float:
    """Return the share of the points that a check has earned."""
    if attempt.error is None:
        return 1.0
    return attempt.error.evidence.share if isinstance(attempt.error, Wrong) else 0.0


def _raised(act: Act, student: Student) -> Exception | None:
    try:
        act(student)
    except Exception as error:  # as with pytest, whatever it is becomes the finding
        return error
    return None


def out_of_memory() -> str:
    """Return how many processes the kernel has killed for want of memory; "" when it hides it."""
    with contextlib.suppress(OSError):
        lines = Path("/proc/vmstat").read_text(encoding="ascii").splitlines()
        return next((line for line in lines if line.startswith("oom_kill ")), "")
    return ""
