"""Fills a Python environment with the packages of a level, by uv or pip.

Standard library only: it runs before any package is there.
"""

from __future__ import annotations

import importlib.util
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from grader.setup.sentences import say, tell

ROOT = Path(__file__).resolve().parent.parent.parent
INSTALL_SECONDS = 1800
MEGABYTES = {"": 0, "grade": 150, "lab": 650, "dev": 1100}  # that an environment takes


class SetupError(Exception):
    """What went wrong and what to do, in one line for the person at the terminal."""


def requirements(level: str) -> Path:
    """Return the list of pinned packages of a level."""
    return ROOT / "grader" / "setup" / "requirements" / f"{level}.txt"


def runs(folder: Path) -> bool:
    """Tell whether the environment's interpreter starts, as the same version as this one."""
    code = "import sys; print(*sys.version_info[:2])"
    command = [str(folder / "bin" / "python"), "-I", "-c", code]
    try:
        answer = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    except (OSError, subprocess.SubprocessError):
        return False
    return answer.stdout.split() == [str(part) for part in sys.version_info[:2]]


def installers() -> list[Callable[[Path, str], str]]:
    """Return the ways to fill an environment, the preferred one first.

    uv is quicker, but does not read pip's settings (a proxy, a mirror): pip comes after it.
    """
    return [install_with_uv, install_with_pip] if shutil.which("uv") else [install_with_pip]


def install_with_uv(folder: Path, level: str) -> str:
    """Fill an environment with uv; return what went wrong, empty when nothing did."""
    problem = ""
    if not runs(folder):
        problem = attempt(["uv", "venv", "--quiet", "--python", sys.executable, str(folder)])
    target = ["--python", str(folder / "bin" / "python")]
    return problem or attempt(["uv", "pip", "install", "--quiet", *target, *sources(level)])


def install_with_pip(folder: Path, level: str) -> str:
    """Fill an environment with pip; return what went wrong, empty when nothing did."""
    problem = ""
    if not runs(folder):
        problem = make_bare(folder)
    pip = [str(folder / "bin" / "python"), "-m", "pip", "install", "--quiet"]
    return problem or attempt([*pip, *sources(level)])


def make_bare(folder: Path) -> str:
    """Make an environment that holds pip alone; return what went wrong, empty when nothing did."""
    if importlib.util.find_spec("ensurepip") is None:
        name = f"python3.{sys.version_info[1]}-venv"
        return say("setup.no_venv", python=sys.executable, name=name)
    return attempt([sys.executable, "-m", "venv", str(folder)])


def check_wheels() -> str:
    """Return the folder of wheels to install from, empty for the network.

    Raises
    ------
    SetupError
        When WHEELS names no folder.
    """
    wheels = os.environ.get("WHEELS", "")
    if wheels and not Path(wheels).is_dir():
        raise SetupError(say("setup.no_wheels", wheels=wheels))
    return wheels


def check_room(folder: Path, level: str, present: str) -> None:
    """Raise SetupError unless what an environment lacks, beyond the level present, has room."""
    needed = MEGABYTES[level] - MEGABYTES[present]
    free = shutil.disk_usage(folder.parent).free // 10**6
    if free < needed:
        raise SetupError(no_room(folder, needed, free))


def no_room(folder: Path, needed: int, free: int | None = None) -> str:
    """Return what is said when an environment does not fit: megabytes, and the cure."""
    left = "" if free is None else say("setup.room_left", free=free)
    return say("setup.no_room", folder=folder, needed=needed, left=left)


def sources(level: str) -> list[str]:
    """Return the arguments of `pip install`: what to install, from where."""
    wheels = check_wheels()
    local = ["--no-index", "--find-links", wheels] if wheels else []
    return [*local, "--requirement", str(requirements(level))]


def attempt(command: list[str]) -> str:
    """Run a command; return the end of what it says when it fails, empty when it works."""
    settings = {
        "PIP_DISABLE_PIP_VERSION_CHECK": "1",
        "PIP_NO_INPUT": "1",
        "PIP_USER": "0",  # some computer rooms set `user = true`, which no environment allows
        "UV_PYTHON_DOWNLOADS": "never",
    }
    try:
        done = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            timeout=INSTALL_SECONDS,
            check=False,
            env={**os.environ, **settings},
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        return str(error)
    return "\n".join(done.stdout.splitlines()[-8:]) or str(done) if done.returncode else ""


def explain(folder: Path, problem: str) -> str:
    """Return an installer's failure with its cause and its cure for the person at the terminal."""
    if any(sign in problem for sign in ("No space left", "Disk quota", "Errno 28", "Errno 122")):
        cure = no_room(folder, MEGABYTES["grade"])
    else:
        cure = say("setup.not_prepared", folder=folder)
    return f"{problem}\n{cure}"


def collect_wheels(folder: Path) -> None:
    """Download the packages of pictures and notebooks into a folder, and say how to use it."""
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        bare = Path(scratch) / "venv"
        pip = [str(bare / "bin" / "python"), "-m", "pip", "download", "--quiet"]
        wanted = ["--only-binary", ":all:", "--requirement", str(requirements("lab"))]
        problem = make_bare(bare) or attempt([*pip, *wanted, "--dest", str(folder)])
    if problem:
        raise SetupError(explain(folder, problem))
    version = f"Python 3.{sys.version_info[1]}, {platform.system()} {platform.machine()}"
    tell(
        "setup.wheels_collected",
        count=len(list(folder.glob("*.whl"))),
        version=version,
        folder=folder.resolve(),
    )
