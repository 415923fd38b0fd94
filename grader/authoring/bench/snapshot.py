"""What a machine holds beside the work at hand: taken before and after, nothing may have come."""

from __future__ import annotations

import contextlib
import os
import stat
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

PLACES = ("/tmp", "/var/tmp", "/dev/shm", "/run", "/etc", "/home", "/var/spool", "/var/mail")
MOST_FILES = 300_000
_IPC = ("shm", "msg", "sem")
# What Python and git write by themselves.
_IGNORED = ("__pycache__", ".git", ".venv", "build")

Snapshot = dict[str, str]  # by the name of a thing, what it looks like


def take(folders: Iterable[Path] = ()) -> Snapshot:
    """Look at the processes, the shared memory, the mounts, and the files of shared places.

    `folders` are further ones, such as a user's own. Linux only.
    """
    found = dict(_processes())
    for kind in _IPC:
        with contextlib.suppress(OSError):
            text = Path(f"/proc/sysvipc/{kind}").read_text(encoding="ascii")
            # The columns that a mere look at the object changes stay out.
            found |= {f"{kind} {line.split()[1]}": "" for line in text.splitlines()[1:]}
    mounts = Path("/proc/self/mountinfo").read_text(encoding="utf-8").splitlines()
    found |= {f"mount {line}": "" for line in mounts}
    places = [*map(Path, PLACES), *folders]
    # Of a folder in another one, each file is listed once.
    for number, (path, look) in enumerate(_files(place for place in places if place.is_dir())):
        if number >= MOST_FILES:
            break
        found[path] = look
    return found


def differences(before: Mapping[str, str], after: Mapping[str, str]) -> list[str]:
    """Return what has come, gone or changed, a line each."""
    came = [f"+ {name}" for name in sorted(after.keys() - before.keys())]
    gone = [f"- {name}" for name in sorted(before.keys() - after.keys())]
    both = sorted(before.keys() & after.keys())
    return [*came, *gone, *(f"~ {name}" for name in both if before[name] != after[name])]


def _processes() -> Iterator[tuple[str, str]]:
    """Yield the processes but this one; a number may be given twice, a number and a start not."""
    for entry in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):  # it has just gone
            fields = (entry / "stat").read_text(errors="replace").rpartition(")")[2].split()
            words = (entry / "cmdline").read_text(errors="replace").replace("\0", " ")
            if int(entry.name) != os.getpid():
                yield f"process {entry.name} of {fields[19]}: {words[:200]}", ""


def _files(places: Iterable[Path]) -> Iterator[tuple[str, str]]:
    for place in places:
        for folder, folders, files in os.walk(place):
            folders[:] = sorted(each for each in folders if each not in _IGNORED)
            for name in [*folders, *files]:
                path = os.path.join(folder, name)
                with contextlib.suppress(OSError):
                    yield path, _look(os.lstat(path))


def _look(status: os.stat_result) -> str:
    """Return what must not change: of a folder, its rights only, since its files are listed."""
    rights = f"{status.st_mode:o} {status.st_uid} {status.st_gid}"
    if stat.S_ISREG(status.st_mode):
        return f"{rights} {status.st_size} {status.st_mtime_ns}"
    return rights
