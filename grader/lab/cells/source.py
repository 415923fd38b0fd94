"""source("shade"): a function as it stands in the student's file, coloured, with its link."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from grader.course import exercises
from grader.lab.display.card import Shown, escape
from grader.lab.display.error_cards import sentence
from grader.lab.display.links import core_folder, link
from grader.lab.display.stopped import Stopped
from grader.lab.display.words import say
from grader.setup import c_text

# Comments, strings and characters: braces in them do not count.


@dataclass(frozen=True)
class Found:
    """Where a function is: its file, its first line (from 1), its text."""

    path: Path
    line: int
    text: str


def source(function: str) -> Shown:
    """Return a function of your own files. Raises Stopped when it is in none of them."""
    found = find(function)
    if found is None:
        raise Stopped(sentence("lab.no_source", name=function, folder=core_folder().name))
    place = link(found.path, found.line)
    head = say("source", function=function)
    return Shown(
        f"<p><b>{escape(head)}</b> {place.html}</p>{coloured(found.text)}",
        f"{head} {place.text}\n{found.text}",
    )


def find(function: str, folder: Path | None = None) -> Found | None:
    """Look for the definition of a function, in its own file first."""
    folder = folder or core_folder()
    rules = exercises.load()
    first = [each.file for each in rules.exercises if function in each.functions]
    others = [name for name in rules.student if name.endswith(".c")]
    names = dict.fromkeys([*first, *others, *sorted(path.name for path in folder.glob("*.c"))])
    for name in names:
        try:
            text = (folder / name).read_text(encoding="utf-8", errors="replace")
        except OSError:
            continue
        span = _span(text, function)
        if span is not None:
            line = text.count("\n", 0, span[0]) + 1
            return Found(folder / name, line, text[span[0] : span[1]])
    return None


def coloured(text: str) -> str:
    """Return C code as HTML with its own colours."""
    from pygments import highlight  # type: ignore[import-untyped]
    from pygments.formatters import HtmlFormatter  # type: ignore[import-untyped]
    from pygments.lexers import CLexer  # type: ignore[import-untyped]

    style = "padding:.5em;border:1px solid #8884;overflow-x:auto;background:#fff;color:#222;"
    style += "font-family:var(--jp-code-font-family, monospace)"
    formatter = HtmlFormatter(noclasses=True, style="friendly_grayscale", prestyles=style)
    return str(highlight(text, CLexer(), formatter))


def _span(text: str, function: str) -> tuple[int, int] | None:
    """Return where a definition begins and ends."""
    bare = c_text.blanked(text)
    # Before the name only words and stars, a type: a call inside an if (...) { is no definition.
    head = re.compile(rf"^[\w \t*]*\b{re.escape(function)}\s*\([^;{{}}]*\)\s*\{{", re.MULTILINE)
    for match in head.finditer(bare):
        depth = 0
        for k in range(match.end() - 1, len(bare)):
            depth += {"{": 1, "}": -1}.get(bare[k], 0)
            if depth == 0:
                return match.start(), k + 1
    return None
