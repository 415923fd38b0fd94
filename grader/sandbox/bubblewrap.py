"""bubblewrap's command lines: an ordinary user's and root's, for running and for compiling.

Inside are the system's programs and libraries, read-only, /dev/null, and what the caller names;
no /proc, no /etc but the loader's cache, no network, no other process. The uid is nobody's.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path

from grader.course.exercises import ROOT
from grader.sandbox import surroundings

NOBODY = 65534
HELP_SECONDS = 20
# Where a system keeps programs and libraries: a folder, or a link into /usr.
_SYSTEM = ("/usr", "/lib", "/lib32", "/lib64", "/libx32", "/bin", "/sbin", "/nix/store")
_FILES = ("/etc/ld.so.cache", "/etc/alternatives")  # cc is a link through the second


def interpreter() -> str:
    """Return the Python that runs this, behind its environment's links."""
    return str(Path(sys.executable).resolve())


def drop() -> list[str]:
    """Return what, before a command, makes root an ordinary user without any privilege."""
    if os.geteuid() != 0:
        return []
    user = [f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups"]
    return ["setpriv", *user, "--inh-caps=-all", "--bounding-set=-all", "--no-new-privs"]


def sandbox(
    readable: Sequence[tuple[str, str]],
    writable: Sequence[str],
    environment: Mapping[str, str],
    command: Sequence[str],
    folder: str = "/",
) -> list[str]:
    """Return the command line that runs a command in a sandbox.

    Parameters
    ----------
    readable
        Pairs of a path outside and the path that it has inside, read-only.
    writable
        Folders that may be written; they have the same path inside.
    environment
        The whole environment of the command.
    folder
        Its working folder, inside.
    """
    words = [_program(), *_namespaces(), *_system()]
    words += _way_to([*(inside for _, inside in readable), *writable])
    for outside, inside in readable:
        words += ["--ro-bind", outside, inside]
    for path in writable:
        words += ["--bind", path, path]
    words += ["--remount-ro", "/", "--chdir", folder]
    for name, value in environment.items():
        words += ["--setenv", name, value]
    return [*words, "--", *drop(), *command]


def _program() -> str:
    """Return bubblewrap where it was found: its own environment may have another PATH."""
    return shutil.which("bwrap") or "bwrap"


def _way_to(paths: Sequence[str]) -> list[str]:
    """Return what makes the folders above these paths, so that root's dropped user passes."""
    words: list[str] = []
    for parent in sorted({each for path in paths for each in Path(path).parents}):
        if parent != Path("/") and not is_system(parent):
            words += [*(("--perms", "0755") if os.geteuid() == 0 else ()), "--dir", str(parent)]
    return words


def _namespaces() -> Iterator[str]:
    yield from ("--unshare-pid", "--unshare-net", "--unshare-ipc", "--unshare-uts")
    yield from ("--unshare-cgroup-try", "--die-with-parent", "--new-session", "--clearenv")
    yield from ("--cap-drop", "ALL")
    if os.geteuid() == 0:
        # With a user namespace of root's own, files of root stay readable: setpriv drops instead.
        for name in ("CAP_SETUID", "CAP_SETGID", "CAP_SETPCAP"):
            yield from ("--cap-add", name)
    else:
        yield from ("--unshare-user", "--uid", str(NOBODY), "--gid", str(NOBODY))
        if "--disable-userns" in _help():  # from 0.8 on
            yield "--disable-userns"


@cache
def _help() -> str:
    done = subprocess.run(
        [_program(), "--help"],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        env=surroundings.of_a_question(),
        timeout=HELP_SECONDS,
        check=False,
    )
    return done.stdout + done.stderr


@cache
def _system() -> tuple[str, ...]:
    """Return the mounts of the system's folders and of the interpreter's own."""
    words: list[str] = []
    for path in map(Path, _SYSTEM):
        if path.is_symlink():
            words += ["--symlink", os.readlink(path), str(path)]
    words += _way_to([*map(str, _folders()), *_FILES, "/dev/null"])
    for path in _folders():
        words += ["--ro-bind", str(path), str(path)]
    if _within(ROOT, _folders()):
        words += ["--tmpfs", str(ROOT)]  # hides the reference and the expected data
    for name in _FILES:
        words += ["--ro-bind-try", name, name]
    return (*words, "--dev-bind", "/dev/null", "/dev/null")


@cache
def _folders() -> tuple[Path, ...]:
    """Return the folders of programs and libraries, the interpreter's own among them."""
    system = [path for path in map(Path, _SYSTEM) if path.is_dir() and not path.is_symlink()]
    prefix = Path(sys.base_prefix).resolve()
    return tuple(system if _within(prefix, system) else [*system, prefix])


def is_system(path: Path) -> bool:
    """Whether a path, without links, is seen inside every sandbox."""
    return _within(path, _folders())


def readable() -> list[str]:
    """Return the places that a confined process reads without a sandbox: those of a sandbox."""
    return [*map(str, _folders()), *_FILES, "/dev/null"]


def _within(path: Path, folders: Sequence[Path]) -> bool:
    return any(path == each or each in path.parents for each in folders)
