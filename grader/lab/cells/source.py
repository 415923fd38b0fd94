"""source("shade"): a function as it stands in the student's file, coloured, with its link."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path

from grader.intake import definitions
from grader.intake.definitions import Definition
from grader.lab.display.card import Shown, escape
from grader.lab.display.error_cards import sentence
from grader.lab.display.links import core_folder, link
from grader.lab.display.stopped import Stopped
from grader.lab.display.words import say


def source(function: str) -> Shown:
    """Return a function of your own files. Raises Stopped when it is in none of them."""
    folder = core_folder()
    found = find(function, folder)
    if found is None:
        raise Stopped(sentence("lab.no_source", name=function, folder=folder.name))
    place = link(folder / found.file, found.line)
    head = say("source", function=function)
    return Shown(
        f"<p><b>{escape(head)}</b> {place.html}</p>{coloured(found.text)}",
        f"{head} {place.text}\n{found.text}",
    )


def find(function: str, folder: Path) -> Definition | None:
    """Look for the definition of a function in the C files of a folder."""
    return definitions.find(function, dict(_texts(folder)))


def _texts(folder: Path) -> Iterator[tuple[str, str]]:
    for path in folder.glob("*.c"):
        with contextlib.suppress(OSError):
            yield path.name, path.read_text(encoding="utf-8", errors="replace")


def coloured(text: str) -> str:
    """Return C code as HTML with its own colours."""
    from pygments import highlight  # type: ignore[import-untyped]
    from pygments.formatters import HtmlFormatter  # type: ignore[import-untyped]
    from pygments.lexers import CLexer  # type: ignore[import-untyped]

    style = "padding:.5em;border:1px solid #8884;overflow-x:auto;background:#fff;color:#222;"
    style += "font-family:var(--jp-code-font-family, monospace)"
    formatter = HtmlFormatter(noclasses=True, style="friendly_grayscale", prestyles=style)
    return str(highlight(text, CLexer(), formatter))
