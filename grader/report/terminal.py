"""Printing the report. Reads JSON only.

On a terminal, rich colours the lines, which are fitted to its width; piped, the same lines come
plain, without drawings, for a screen reader or a file. What is not written yet is calm: colour is
for what was tried.
"""

from __future__ import annotations

import re
import sys
import textwrap
from pathlib import Path
from typing import TextIO

from rich.console import Console
from rich.text import Text

from grader.course.texts import Texts
from grader.report.results import Row
from grader.report.text import View

MAX_WIDTH = 100  # of sentences: longer lines are hard to read
# What stays on one line: French punctuation and the word before it, points, a command.
_INSEPARABLE = re.compile(r" [:;?!»%]|« |\d / \d|make \w+ [A-Z]+=")
_GLUE = "\u00a0"


def show(content: Row, path: Path, texts: Texts, out: TextIO | None = None) -> None:
    """Print the content of results.json; `path` is where it is, to be named."""
    out = out or sys.stdout
    console = Console(file=out, highlight=False, soft_wrap=True)
    width = console.width if console.is_terminal else 0
    for line, style in View(content, path, texts, width).lines():
        for text in _folded(_printable(line), width):
            if console.is_terminal:
                console.print(Text(text, style=style))
            else:
                out.write(f"{text}\n")


def _printable(line: str) -> str:
    """Return the line without the control characters that a submission may have put in it."""
    return "".join(each if each.isprintable() else "�" for each in line.expandtabs()).rstrip()


def _folded(line: str, width: int) -> list[str]:
    """Fold a sentence to the terminal's width, under its own beginning."""
    if not width or len(line) <= min(width, MAX_WIDTH):
        return [line]
    indent = line[: len(line) - len(line.lstrip())]
    if "|" in line[:12] or len(indent) > 2:  # a source line of the compiler's, or a table's
        return [line]
    whole = _INSEPARABLE.sub(lambda found: found[0].replace(" ", _GLUE), line)
    folded = textwrap.wrap(
        whole, min(width, MAX_WIDTH), subsequent_indent=indent, break_on_hyphens=False
    )
    return [each.replace(_GLUE, " ") for each in folded]
