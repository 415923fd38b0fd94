"""Runs commands as a person at a terminal would, for the tests of the house."""

from __future__ import annotations

import os
import stat
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
NOBODY = 65534
OURS = ("PYTHON", "MRT_ENV", "BUILD", "WHEELS", "MRT_LANG", "CC", "SRC", "PLATFORM", "SUBMISSION")


def run(
    *command: str, cwd: Path, ordinary: bool = False, **settings: str
) -> subprocess.CompletedProcess[str]:
    """Run a command with the given settings, as a user without rights when root and asked to."""
    inherited = {
        name: value
        for name, value in os.environ.items()
        if name not in OURS and not name.startswith("MAKE")
    }
    drop = ordinary and os.geteuid() == 0
    return subprocess.run(
        command,
        cwd=cwd,
        env={**inherited, "HOME": str(cwd), **settings},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        user=NOBODY if drop else None,
        group=NOBODY if drop else None,
        extra_groups=[] if drop else None,
    )


def reachable(path: Path) -> bool:
    """Tell whether every user can walk to a file and use it."""
    return all(p.stat().st_mode & stat.S_IXOTH for p in (path.resolve(), *path.resolve().parents))


def script(path: Path, text: str) -> Path:
    """Write an executable shell script."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{text}\n", encoding="utf-8")
    path.chmod(0o755)
    return path
