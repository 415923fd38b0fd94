"""How a process that ran student code ended."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum


class Cause(str, Enum):
    """How the process that ran the student's code ended before it had answered."""

    SIGNAL = "signal"
    EXIT = "exit"  # the code called exit, or closed the grader's channel
    TIMEOUT = "timeout"  # it computed for too long
    WAITING = "waiting"  # it neither computed nor queued for a processor, for too long
    SPENT = "spent"  # the submission has taken all that it may in all; the word says of what
    LOAD = "load"  # the library cannot be loaded: a global is missing
    MEMORY = "memory"  # none was left to go on with
    STRAY_WRITE = "stray_write"  # a write just before a table, seen after the call
    UNSET_RESULT = "unset_result"  # a bool that is neither true nor false, seen after the call
    KILLED = "killed"  # by SIGKILL, which nothing of ours sent: by itself, or from outside


@dataclass(frozen=True)
class Act:
    """Something that isolation may refuse: "thread", "process", "file" or "network", and where."""

    kind: str
    worked: bool
    function: str = ""
    location: str = ""  # "file:line"


OUT_OF_TIME = (Cause.TIMEOUT, Cause.WAITING, Cause.SPENT)


@dataclass(frozen=True)
class Death:
    """Why a process that ran student code is gone.

    `word` is a signal's name (SIGFPE), or the sanitizer's word (heap-buffer-overflow) or one of its
    kind: null-pointer, stack-overflow;
    `case` is the number, in the batch, of the call that was running; `location` is "file:line"
    or "".
    """

    cause: Cause
    word: str = ""
    code: int = 0
    case: int = 0
    location: str = ""
    text: str = ""
    function: str = ""  # in which it was, when that is known
    # The calls that had led there, each with its "file:line", from the inside out.
    callers: tuple[tuple[str, str], ...] = field(default=(), compare=False)
    seconds: float = field(default=0.0, compare=False)  # that it was allowed


@dataclass(frozen=True)
class Limits:
    """Bounds of one session: CPU seconds, and bytes of memory beyond what the worker uses.

    The seconds are those of the whole session; with `each_call`, of each request, for a session
    that stays; with `each_check`, of each check that it serves, one after the other.
    """

    cpu: float = 10.0
    memory: int = 512 << 20
    each_call: bool = False
    each_check: bool = False

    @property
    def wall(self) -> float:
        """Seconds of waiting for one answer: generous, a loaded machine is not the code's fault."""
        return 3 * self.cpu + 2
