"""Where things are: the student's files, the outputs, and links that open a file in JupyterLab."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any
from urllib.parse import quote

from grader.course.exercises import CORE, ROOT
from grader.lab.display.card import Shown, escape

VARIABLE = "MRT_CORE"


def core_folder(asked: str | os.PathLike[str] | None = None) -> Path:
    """Return the folder of C files.

    It is the one asked for, or MRT_CORE's, or the first `core_c` from here upwards.
    """
    named = asked or os.environ.get(VARIABLE)
    if named:
        return Path(named).resolve()
    here = Path.cwd()
    found = (each / CORE.name for each in (here, *here.parents))
    return next((each for each in found if each.is_dir()), CORE).resolve()


def outputs() -> Path:
    """Return the folder of everything that is made here."""
    return (ROOT / (os.environ.get("BUILD") or "build")).resolve()


def link(path: Path, line: int = 0, words: str = "") -> Shown:
    """Return a link that opens a file in JupyterLab, beside the notebook, at a line if given."""
    place = f"{path.name}:{line}" if line else path.name
    # JupyterLab counts lines from 0 there.
    target = quote(os.path.relpath(path, Path.cwd())) + (f"#line={line - 1}" if line else "")
    return Shown(f'<a href="{target}">{escape(words or place)}</a>', words or place)


def graded() -> dict[str, Any]:
    """Return the results of the last whole grade; nothing when there is none that can be read."""
    try:
        content = json.loads((outputs() / "grade" / "results.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return content if isinstance(content, dict) else {}
