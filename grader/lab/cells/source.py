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

_PALE = "var(--jp-content-font-color2, #595959)"
_BLOCK = (
    "padding:.5em;margin:.4em 0;border:1px solid #808080;"
    "white-space:pre-wrap;word-break:normal;overflow-wrap:anywhere;"
    "background:var(--jp-layout-color0, #fff);color:var(--jp-content-font-color1, #222);"
    "font-family:var(--jp-code-font-family, monospace)"
)


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
    """Return C code as HTML: keywords bold, comments slanted, in the colours of the theme."""
    from pygments.lexers import CLexer  # type: ignore[import-untyped]
    from pygments.token import Comment, Keyword  # type: ignore[import-untyped]

    parts = []
    for kind, word in CLexer(stripnl=False).get_tokens(text):
        if kind in Comment and kind not in Comment.Preproc:
            parts.append(f'<i style="color:{_PALE}">{escape(word)}</i>')
        else:
            parts.append(f"<b>{escape(word)}</b>" if kind in Keyword else escape(word))
    return f'<pre style="{_BLOCK}">{"".join(parts)}</pre>'
