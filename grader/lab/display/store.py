"""Small files in build/lab/: written whole, and read back even when they were damaged."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from grader.files import write_whole
from grader.lab.display.links import outputs


def read(name: str) -> dict[str, Any]:
    """Return the content of a file; a damaged one is set aside, and nothing is known."""
    path = _path(name)
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError:
        return {}
    except ValueError:
        content = None
    if not isinstance(content, dict):
        path.replace(path.with_suffix(".damaged"))
        return {}
    return content


def write(name: str, content: dict[str, Any]) -> None:
    """Write a file of build/lab/. Raises OSError."""
    write_json(_path(name), content)


def write_json(path: Path, content: dict[str, Any]) -> None:
    """Write a file whole: others find the old one or the new one. Raises OSError."""
    write_whole(path, json.dumps(content, ensure_ascii=False, indent=1))


def _path(name: str) -> Path:
    return outputs() / "lab" / name
