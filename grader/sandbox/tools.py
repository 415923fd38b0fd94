"""Runs the compiler, the linker and the tools that read what they made: all are fed by strangers.

They get the limits of isolation.md, see the files that they are given and the system's, and write
to one folder.
"""

from __future__ import annotations

import contextlib
import errno
import os
import select
import shutil
import signal
import stat
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from grader.sandbox import bubblewrap
from grader.sandbox.levels import Level, current
from grader.sandbox.staging import stage

CPU_SECONDS = 10
MEMORY_BYTES = 1536 << 20
FILE_BYTES = 32 << 20
OUT_OF_TIME = -1000  # as a status: no signal's number
MAX_OUTPUT_BYTES = 200_000  # of messages that are kept
ENVIRONMENT = {"PATH": "/usr/bin:/bin", "LC_ALL": "C.UTF-8"}


@dataclass(frozen=True)
class ToolResult:
    """How a tool ended: its exit status, and the beginning of what it said."""

    status: int
    output: str
    errors: str

    @property
    def killed(self) -> bool:
        """Whether somebody has killed it, or what started it: its limits end it otherwise."""
        return self.status in (-signal.SIGKILL, 128 + signal.SIGKILL)


def run_tool(
    command: Sequence[str],
    folder: Path,
    readable: Sequence[Path] = (),
    writable: Sequence[Path] = (),
    seconds: float = 30,
) -> ToolResult:
    """Run a tool in a folder, which it can read; it sees the other files only if they are listed.

    Raises OSError when it cannot be started.
    """
    folder = folder.resolve()
    program = _program(command[0])
    words = [program, *command[1:]]
    environment = {**ENVIRONMENT, "PATH": os.pathsep.join(_path(program))}
    if writable:
        environment["TMPDIR"] = str(writable[0].resolve())
    paths = [folder, *(each.resolve() for each in readable), *_toolchain(program)]
    with tempfile.TemporaryFile() as output, tempfile.TemporaryFile() as errors:
        line = _line(words, folder, paths, [each.resolve() for each in writable], environment)
        tool = subprocess.Popen(
            line,
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=errors,
            env=environment,
            start_new_session=True,
        )
        return ToolResult(finish(tool, seconds), _beginning(output), _beginning(errors))


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
    if not sys.platform.startswith("linux") or shutil.which("prlimit") is None:
        return []
    limits = [f"--cpu={CPU_SECONDS}:{CPU_SECONDS + 1}", f"--as={MEMORY_BYTES}"]
    return ["prlimit", *limits, f"--fsize={FILE_BYTES}", "--core=0", "--"]


def _beginning(file: IO[bytes]) -> str:
    file.seek(0)
    return file.read(MAX_OUTPUT_BYTES).decode(errors="replace")
