"""One run of the compiler, the linker or objcopy, shut in: what it made, or why it made nothing.

What is said of a failure by its own words decides nothing: a source can make the compiler say
whatever it likes. How it ended is read from the statuses of the processes.
"""

from __future__ import annotations

import os
import re
import signal
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from grader.build import toolchain
from grader.course.message import UserError
from grader.sandbox import tools
from grader.sandbox.budget import Budget
from grader.sandbox.tools import OUT_OF_TIME, ToolResult, give_away, run_tool, take_back

_POSITION = re.compile(
    r":\d+:|undefined|not defined|multiple definition"
)  # where, or in what, an error is
_NO_PLACE = re.compile(r"^cc1(?:plus)?(?=: fatal error: )", re.MULTILINE)  # of a whole file
_INTERNAL_ERROR = 4  # gcc's status for a fault of its own: most often one of our limits


class BuildError(UserError):
    """The machine or the given files are at fault, not the submission."""


@dataclass(frozen=True)
class Made:
    """What came of a run: `said` are the messages, of errors when it failed.

    `slow`: it was given up, and would be again.
    """

    failed: bool
    said: str = ""
    slow: bool = False


def make(
    command: Sequence[str],
    output: Path,
    cwd: Path,
    inputs: Sequence[Path],
    name: str,
    budget: Budget | None = None,
) -> Made:
    """Run a command to whose end the output's name is added; the output appears when it is whole.

    `inputs` are the files that it reads beside those of `cwd` and the system's; `name` is that of
    what is compiled, for messages; `budget` is the submission's, None for what is not its own.
    Raises BuildError when the machine is at fault.
    """
    seconds = min(toolchain.COMPILE_SECONDS, budget.left() if budget else toolchain.COMPILE_SECONDS)
    if budget and budget.spent:
        return Made(True, _error(name, "the submission's time is used up: it was not compiled"))
    output.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=output.parent) as folder:
        give_away(Path(folder))
        part = Path(folder) / f"output{output.suffix}"
        ran = run_tool([*command, str(part.resolve())], cwd, inputs, [Path(folder)], seconds)
        if ran.status == 0:
            take_back(part)
            os.replace(part, output)
    if budget:
        budget.spend(cpu=ran.cpu)
    return _made(ran, command[0], name, str(part.resolve().parent))


def _made(ran: ToolResult, command: str, name: str, folder: str) -> Made:
    if ran.status == 0:
        return Made(False, ran.errors)
    if not ran.began:
        raise BuildError("machine.failed", detail=_first_line(ran.errors) or command)
    if ran.status == OUT_OF_TIME or signal.SIGXCPU in ran.signals:
        why = f"compiling takes too long: more than {tools.CPU_SECONDS} s of computing"
        return Made(True, _error(name, why), slow=True)
    if ran.killed:
        # Its own limits end it otherwise: somebody, or a machine short of memory, has killed it.
        raise BuildError("machine.compiler_killed", command=command)
    if signal.SIGXFSZ in ran.signals:
        why = f"what is made of it takes more than {tools.FILE_BYTES >> 20} MB"
        return Made(True, _error(name, why), slow=True)
    gave_up = bool(ran.signals) or _INTERNAL_ERROR in ran.parts
    errors = _NO_PLACE.sub(f"{name}:1:1", ran.errors)
    if gave_up or not _POSITION.search(errors):
        why = f"the compiler gives up, within {tools.MEMORY_BYTES >> 20} MB of memory"
        return Made(True, _error(name, why), slow=gave_up)
    # The assembler tells the name of its input, which is nobody's business.
    said = re.sub(rf"{re.escape(folder)}/cc\w+", "asm", errors)
    return Made(True, said.replace(folder, "") or _error(name, f"{command} fails"))


def _error(name: str, why: str) -> str:
    """Return an error as a compiler writes it."""
    return f"{name}:1:1: error: {why}\n"


def _first_line(text: str) -> str:
    return next(iter(text.strip().splitlines()), "")[:300]
