"""What a notebook that was run shows, as text."""

from __future__ import annotations

import re
from typing import Any


def shown(notebook: Any) -> list[tuple[str, str]]:
    """Return the source of each cell that was run, and all that it shows as text."""
    return [
        (each.source, "\n".join(map(text_of, each.outputs)))
        for each in notebook.cells
        if each.cell_type == "code"
    ]


def text_of(output: Any) -> str:
    """Return an output as text; that of an error tells its name."""
    if output.output_type == "error":
        return f"ERROR {output.ename}"
    return str(output.get("text") or output.data.get("text/plain", ""))


def checks(notebook: Any) -> dict[str, str]:
    """Return what each check cell says, by exercise."""
    found = {}
    for source, text in shown(notebook):
        if match := re.fullmatch(r'check\("(\S+)"\)', source):
            found[match[1]] = text
    return found
