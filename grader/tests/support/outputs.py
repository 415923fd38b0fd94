"""A folder of outputs, as BUILD= names one, without building again what another test has built."""

from __future__ import annotations

from pathlib import Path


def outputs(folder: Path, cache: Path) -> Path:
    """Make the folder, whose builds are those that all the tests share; return it."""
    folder.mkdir(exist_ok=True)
    if not (folder / "cache").exists():
        (folder / "cache").symlink_to(cache)
    return folder
