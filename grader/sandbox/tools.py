"""Runs the compiler, the linker and the tools that read what they made: all are fed by strangers.

They get the limits of isolation.md, see the files that they are given and the system's, and write
to one folder.
"""

from __future__ import annotations

import contextlib
import errno
import os
import re
import select
import shutil
import signal
import stat
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO

from grader.sandbox import bubblewrap
from grader.sandbox.levels import Level, current
from grader.sandbox.staging import stage
from grader.sandbox.surroundings import LOCALE

CPU_SECONDS = 10
MEMORY_BYTES = 1536 << 20
FILE_BYTES = 32 << 20
OUT_OF_TIME = -1000  # as a status: no signal's number
MAX_OUTPUT_BYTES = 200_000  # of messages that are kept
ENVIRONMENT = {"PATH": "/usr/bin:/bin", **LOCALE}
# What tells how a tool ended: a shell around it, behind the sandbox and the limits, which writes to
# a file of ours. Its words come from nothing that the tool reads or prints.
_REPORTING = 'echo began >&0; "$@" {redirected}; s=$?; {{ echo ended $s; times; }} >&0; exit $s'
_ALONE, _WITH_PARTS = "</dev/null", "3>&0 </dev/null"
# The same around each program that gcc starts in its turn, as its option.
PARTS = ("-wrapper", 'sh,-c,"$@" 3>&-; s=$?; echo part $s >&3; exit $s,sh')
_SHELL_SIGNAL = 128  # a shell adds it to a signal's number
_NOT_STARTED = (126, 127)
_SECONDS = re.compile(r"(\d+)m([\d.]+)s")


@dataclass(frozen=True)
class ToolResult:
    """How a tool ended: its exit status, the beginning of what it said, and the CPU seconds.

    `parts` are the statuses of the programs that it started, as a shell tells them, and `signals`
    those that ended it or one of them. `began` is false when what shuts it in has failed: whatever
    was said is not the tool's; `cut`, that it said more than is kept.
    """

    status: int
    output: str
    errors: str
    began: bool = True
    cut: bool = False
    parts: tuple[int, ...] = ()
    signals: frozenset[int] = frozenset()
    cpu: float = 0.0

    @property
    def killed(self) -> bool:
        """Whether somebody has killed it, or what started it: its limits end it otherwise."""
        return signal.SIGKILL in self.signals


def run_tool(
    command: Sequence[str],
    folder: Path,
    readable: Sequence[Path] = (),
    writable: Sequence[Path] = (),
    seconds: float = 30,
    most: int = MAX_OUTPUT_BYTES,
) -> ToolResult:
    """Run a tool in a folder, which it can read; it sees the other files only if they are listed.

    `most` bounds the bytes of output that are kept. Raises OSError when it cannot be started.
    """
    folder = folder.resolve()
    program = _program(command[0])
    redirected = _WITH_PARTS if PARTS[0] in command else _ALONE
    words = ["sh", "-c", _REPORTING.format(redirected=redirected), "sh", program, *command[1:]]
    environment = {**ENVIRONMENT, "PATH": os.pathsep.join(_path(program))}
    if writable:
        environment["TMPDIR"] = str(writable[0].resolve())
    paths = [folder, *(each.resolve() for each in readable), *_toolchain(program)]
    line = _line(words, folder, paths, [each.resolve() for each in writable], environment)
    with (
        tempfile.TemporaryFile() as output,
        tempfile.TemporaryFile() as errors,
        tempfile.TemporaryFile() as report,
    ):
        tool = subprocess.Popen(
            line,
            cwd=folder,
            stdin=report,
            stdout=output,
            stderr=errors,
            env=environment,
            start_new_session=True,
        )
        status = finish(tool, seconds)
        ran = _result(status, seconds, _beginning(report, MAX_OUTPUT_BYTES))
        cut = os.fstat(output.fileno()).st_size > most
        said = _beginning(output, most), _beginning(errors, most)
        return replace(ran, output=said[0], errors=said[1], cut=cut)


def _result(status: int, seconds: float, report: str) -> ToolResult:
    """Return how a tool ended, by its status as seen from here and by the report on it."""
    lines = [line.split() for line in report.splitlines()]
    parts = [int(words[1]) for words in lines if words[0] == "part"]
    statuses = parts + [int(words[1]) for words in lines if words[0] == "ended"]
    signals = {each - _SHELL_SIGNAL for each in statuses if each > _SHELL_SIGNAL}
    ended = any(words[0] == "ended" for words in lines)
    if not ended and status != OUT_OF_TIME:  # the shell itself, or what is around it
        signals |= {-status} if status < 0 else {status - _SHELL_SIGNAL}
    cpu = sum(60 * float(minutes) + float(rest) for minutes, rest in _SECONDS.findall(report))
    return ToolResult(
        status,
        "",
        "",
        began=["began"] in lines and status not in _NOT_STARTED,
        parts=tuple(parts),
        signals=frozenset(each for each in signals if each > 0),
        cpu=cpu if ended else min(seconds, CPU_SECONDS),
    )


def finish(process: subprocess.Popen[bytes], seconds: float) -> int:
    """Wait for the end of a process that leads its own session; return its status.

    After so many seconds it is killed with its session, and OUT_OF_TIME returned.
    """
    try:
        _wait(process, seconds)
        on_time = process.poll() is not None
    finally:
        if process.poll() is None:
            with contextlib.suppress(ProcessLookupError, PermissionError):  # it has just ended
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
    return process.returncode if on_time else OUT_OF_TIME


def _wait(process: subprocess.Popen[bytes], seconds: float) -> None:
    if not hasattr(os, "pidfd_open"):
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(seconds)  # sleeps between looks, for up to 50 ms
        return
    descriptor = os.pidfd_open(process.pid)
    try:
        select.select([descriptor], [], [], seconds)
    finally:
        os.close(descriptor)


def give_away(folder: Path) -> None:
    """Let a tool write to a folder: root's tools run as nobody in a sandbox."""
    if os.geteuid() == 0:
        os.chown(folder, bubblewrap.NOBODY, bubblewrap.NOBODY)


def take_back(path: Path) -> None:
    """Make what a tool has written ours. Raises OSError unless it is a plain file."""
    if not stat.S_ISREG(path.lstat().st_mode):
        raise OSError(errno.EINVAL, "not a plain file", str(path))
    if os.geteuid() == 0:
        os.chown(path, 0, 0)
    path.chmod(0o755)


def _program(name: str) -> str:
    found = shutil.which(name)
    if found is None:
        raise FileNotFoundError(errno.ENOENT, "not found", name)
    return os.path.abspath(found)


def _path(program: str) -> list[str]:
    """Return the folders in which a compiler looks for its assembler and its linker."""
    return list(dict.fromkeys([os.path.dirname(program), "/usr/bin", "/bin"]))


def _toolchain(program: str) -> list[Path]:
    """Return where a compiler that does not stand among the system's has its files."""
    prefix = Path(program).resolve().parent.parent
    return [] if bubblewrap.is_system(prefix) else [prefix]


def _line(
    words: Sequence[str],
    folder: Path,
    readable: Sequence[Path],
    writable: Sequence[Path],
    environment: Mapping[str, str],
) -> list[str]:
    level = current().level
    if level is Level.STRONG:
        pairs = [(str(path), str(path)) for path in dict.fromkeys(readable)]
        folders = [str(path) for path in writable]
        return bubblewrap.sandbox(pairs, folders, environment, [*_limits(), *words], str(folder))
    if level is Level.MEDIUM:
        # Without namespaces: Landlock, set by a small program that then becomes the tool.
        places = [f"--read={path}" for path in (*bubblewrap.readable(), *readable)]
        places += [f"--write={path}" for path in writable]
        launch = [bubblewrap.interpreter(), "-S", "-s", "-B", str(stage() / "launch.py")]
        return [*launch, *places, "--", *_limits(), *words]
    return [*_limits(), *words]


def _limits() -> list[str]:
    """Return what, before a command, bounds its time, memory and files; nothing on macOS."""
    program = shutil.which("prlimit")
    if not sys.platform.startswith("linux") or program is None:
        return []
    limits = [f"--cpu={CPU_SECONDS}:{CPU_SECONDS + 1}", f"--as={MEMORY_BYTES}"]
    return [program, *limits, f"--fsize={FILE_BYTES}", "--core=0", "--"]


def _beginning(file: IO[bytes], most: int) -> str:
    file.seek(0)
    return file.read(most).decode(errors="replace")
