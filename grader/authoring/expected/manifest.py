"""Writes the manifest of a folder of expected data, and files with what it says of each."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from grader.checking.expected_data import read_manifest
from grader.files import write_whole


def write_manifest(folder: Path, content: Mapping[str, Any]) -> None:
    """Write the manifest of a folder, its files by name. Raises OSError."""
    whole = {**content, "files": dict(sorted(content["files"].items()))}
    text = json.dumps(whole, indent=1, ensure_ascii=False) + "\n"
    write_whole(folder / "manifest.json", text)


def put(folder: Path, files: Mapping[str, bytes], rules: Mapping[str, Any]) -> dict[str, Any]:
    """Write files into a folder; return what its manifest says of them: their sums, and `rules`."""
    for name, content in files.items():
        write_whole(folder / name, content)
    return {
        name: {"sha256": hashlib.sha256(content).hexdigest(), **rules}
        for name, content in files.items()
    }


def changed(now: Mapping[str, str], kept: Mapping[str, str]) -> list[str]:
    """Return the names of which what something is made of now is not what it was."""
    return sorted(name for name in now.keys() | kept if now.get(name) != kept.get(name))


def drop(folder: Path, name: str) -> None:
    """Take a file out of a folder and its manifest, if it is there. Raises ExpectedError."""
    manifest = read_manifest(folder)
    manifest["files"].pop(name, None)
    write_manifest(folder, manifest)
    (folder / name).unlink(missing_ok=True)


def merge(folder: Path, files: Mapping[str, bytes], rules: Mapping[str, Any]) -> None:
    """Put files into a folder and its manifest; the others stay. Raises ExpectedError, OSError."""
    manifest = read_manifest(folder)
    manifest["files"] |= put(folder, files, rules)
    write_manifest(folder, manifest)
