"""Printing the report. Reads JSON only.

On a terminal, rich colours the lines, which are fitted to its width; piped, the same lines come
plain, without drawings, for a screen reader or a file. What is not written yet is calm: colour is
for what was tried.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TextIO

from rich.console import Console
from rich.text import Text

from grader.course.texts import Texts
from grader.report.results import Row
from grader.report.summary import Line
from grader.report.text import View
from grader.setup.folding import folded


def show(content: Row, path: Path, texts: Texts, out: TextIO | None = None) -> None:
    """Print the content of results.json; `path` is where it is, to be named."""
    out = out or sys.stdout
    console = Console(file=out, highlight=False, soft_wrap=True)
    width = console.width if console.is_terminal else 0
    _print(View(content, path, texts, width).lines(), console)


def put(lines: Iterable[Line], out: TextIO | None = None) -> None:
    """Print lines with their styles."""
    _print(lines, Console(file=out or sys.stdout, highlight=False, soft_wrap=True))


def _print(lines: Iterable[Line], console: Console) -> None:
    width = console.width if console.is_terminal else 0
    for line, style in lines:
        for text in folded(_printable(line), width):
            if console.is_terminal:
                console.print(Text(text, style=style))
            else:
                console.file.write(f"{text}\n")


def list_lines(lines: Iterable[str], out: TextIO | None = None) -> None:
    """Print lines for another program, whole, after an empty one."""
    print("", *map(_printable, lines), sep="\n", file=out or sys.stdout)


def _printable(line: str) -> str:
    """Return the line without the control characters that a submission may have put in it."""
    return "".join(each if each.isprintable() else "�" for each in line.expandtabs()).rstrip()
