"""Makes the Python environment that the commands run in, once, and tells whether it is ready.

Run by environment.sh. Standard library only: it runs before any package is there.

An environment holds one level of packages (`requirements/LEVEL.txt`), each level with those below.
A stamp, written last and removed first, says which: without it an environment is made again.
A lock file beside the environment is held while it is made, so that two `make` at once do not harm
each other; it also tells our `.venv` from one that somebody else put there, which is left alone.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import hashlib
import importlib.metadata
import os
import re
import shutil
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from grader.setup.folding import put
from grader.setup.install import (
    ROOT,
    SetupError,
    check_room,
    check_wheels,
    collect_wheels,
    explain,
    installers,
    requirements,
    runs,
)
from grader.setup.sentences import say, tell

LEVELS = ("grade", "lab", "dev")
STAMP = "mrt-stamp"
LOCK_SECONDS = 1800


def stamp_text(level: str) -> str:
    """Return what the stamp of a ready environment of this interpreter and level holds."""
    digest = hashlib.sha256(requirements(level).read_bytes()).hexdigest()
    return f"{level} {sys.version_info[0]}.{sys.version_info[1]} {digest}\n"


def read_stamp(folder: Path) -> str:
    """Return the stamp of an environment, empty when there is none."""
    try:
        return (folder / STAMP).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return ""


def is_ready(folder: Path, level: str) -> bool:
    """Tell whether an environment holds this level, or a higher one, for this interpreter."""
    stamp = read_stamp(folder)
    return any(stamp == stamp_text(name) for name in LEVELS[LEVELS.index(level) :])


def lock_path(folder: Path) -> Path:
    """Return the file that is held while an environment is made."""
    return folder.with_name(folder.name + ".lock")


def is_ours(folder: Path) -> bool:
    """Tell whether we may make, or make again, an environment in this folder."""
    try:
        return not folder.exists() or (lock_path(folder).exists() and os.access(folder, os.W_OK))
    except OSError:
        return False


def choose_folder(build: Path) -> Path:
    """Return where to make the environment: `.venv`, else `venv` in the folder of outputs.

    Raises
    ------
    SetupError
        When neither can be written.
    """
    if os.access(ROOT, os.W_OK) and is_ours(ROOT / ".venv"):
        return ROOT / ".venv"
    with contextlib.suppress(OSError):
        build.mkdir(parents=True, exist_ok=True)
    if os.access(build, os.W_OK) and is_ours(build / "venv"):
        return build / "venv"
    raise SetupError(say("setup.environment_unwritable", root=ROOT, build=build))


@contextlib.contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold the lock of an environment; the system drops it with the process, however it ends."""
    with lock_path(folder).open("w") as handle:
        deadline = time.monotonic() + LOCK_SECONDS
        told = False
        while not try_lock(handle.fileno()):
            if not told:
                tell("setup.waiting")
                told = True
            if time.monotonic() > deadline:
                raise SetupError(say("setup.waited_too_long", folder=folder))
            time.sleep(0.2)
        yield


def try_lock(descriptor: int) -> bool:
    """Take a lock if it is free; a file system without locks counts as free."""
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        return error.errno not in (errno.EWOULDBLOCK, errno.EACCES, errno.EINTR)
    return True


def make(level: str, build: Path) -> Path:
    """Return a ready environment of this level, made or completed if need be."""
    for folder in (ROOT / ".venv", build / "venv"):
        if is_ready(folder, level) and runs(folder):
            return folder
    folder = choose_folder(build)
    with locked(folder):
        if not (is_ready(folder, level) and runs(folder)):
            fill(folder, level)
    return folder


def fill(folder: Path, level: str) -> None:
    """Install a level's packages in a new environment, or in one of an earlier or lower level."""
    check_wheels()  # before anything is undone
    stamped = read_stamp(folder).partition(" ")[0]
    present = stamped if stamped in LEVELS and runs(folder) else ""
    check_room(folder, level, present)
    minutes = say("setup.a_minute" if level == "grade" else "setup.minutes")
    tell("setup.preparing", folder=folder, minutes=minutes)
    if present:
        level = max(level, present, key=LEVELS.index)
        (folder / STAMP).unlink()
    elif folder.exists():
        shutil.rmtree(folder)
    problems = []
    for install in installers():
        problem = install(folder, level)
        if not problem:
            (folder / STAMP).write_text(stamp_text(level), encoding="utf-8")
            return
        problems.append(problem)
        shutil.rmtree(folder, ignore_errors=True)
    raise SetupError(explain(folder, "\n".join(problems)))


def missing_packages(level: str) -> list[str]:
    """Return the packages asked for by a level, or those below, that this interpreter lacks."""
    names = []
    for below in LEVELS[: LEVELS.index(level) + 1]:
        for line in requirements(below).with_suffix(".in").read_text(encoding="utf-8").splitlines():
            name = re.match(r"[\w.-]+", line)
            if name and not line.startswith("-r") and applies(line):
                names.append(name[0])
    return [name for name in dict.fromkeys(names) if not has_package(name)]


def applies(line: str) -> bool:
    """Tell whether a requirement's condition on Python's version, if any, holds here."""
    condition = re.search(r'python_version (<|>=) "3\.(\d+)"', line)
    if condition is None:
        return True
    return (sys.version_info[1] < int(condition[2])) == (condition[1] == "<")


def has_package(name: str) -> bool:
    """Tell whether this interpreter has a package, of any version."""
    try:
        importlib.metadata.distribution(name)
    except importlib.metadata.PackageNotFoundError:
        return False
    return True


def check(level: str) -> None:
    """Raise SetupError unless this interpreter, of a shared environment, has a level's packages."""
    place = os.environ.get("MRT_ENV", sys.prefix)
    missing = ", ".join(missing_packages(level))
    if missing:
        raise SetupError(say("setup.packages_missing", place=place, missing=missing, level=level))


def run(action: str, arguments: list[str]) -> int:
    """Carry out one action of environment.sh; return the exit code."""
    if action == "wheelhouse":
        collect_wheels(Path(arguments[0]))
    elif action == "check":
        check(arguments[0])
        print(sys.executable)
    elif action == "ready":
        level, folder = arguments
        if not is_ready(Path(folder), level):
            return 1
        print(sys.executable)
    else:
        level, build = arguments
        print(make(level, Path(build).resolve()) / "bin" / "python")
    return 0


def main() -> int:
    """Run as a script: ACTION ARGUMENT..."""
    os.umask(0o022)  # a sandbox's dropped user must be able to read the environment
    try:
        return run(sys.argv[1], sys.argv[2:])
    except SetupError as trouble:
        put(str(trouble), sys.stderr)
    except OSError as error:
        put(explain(Path(error.filename or ROOT), str(error)), sys.stderr)
    except KeyboardInterrupt:
        pass  # without a stamp the next make starts again
    return 1


if __name__ == "__main__":
    sys.exit(main())
