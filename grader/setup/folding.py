"""Sentences folded to the width of a terminal. Standard library only: all that prints uses it."""

from __future__ import annotations

import os
import re
import textwrap
from typing import TextIO

MAX_WIDTH = 100  # of sentences: longer lines are hard to read
# What stays on one line: French punctuation and the word before it, points, a command.
_INSEPARABLE = re.compile(r" [:;?!»%]|« |\d / \d|make \w+(?: [A-Z]+=\S+)*")
_GLUE = "\u00a0"


def put(text: str, out: TextIO) -> None:
    """Write lines of text, folded where a person reads them."""
    columns = width(out)
    for line in text.split("\n"):
        out.writelines(f"{each}\n" for each in folded(line, columns))


def width(out: TextIO) -> int:
    """Return how many columns a terminal has; 0 for a file or a pipe."""
    if not out.isatty():
        return 0
    try:
        return os.get_terminal_size(out.fileno()).columns
    except (OSError, ValueError):
        return 0


def folded(line: str, columns: int) -> list[str]:
    """Fold a sentence, under its own beginning, to a number of columns; 0: not at all.

    A source line of the compiler's, or a table's, is left as it is.
    """
    if not columns or len(line) <= min(columns, MAX_WIDTH):
        return [line]
    indent = line[: len(line) - len(line.lstrip())]
    if "|" in line[:12] or len(indent) > 2:
        return [line]
    whole = _INSEPARABLE.sub(lambda found: found[0].replace(" ", _GLUE), line)
    lines = textwrap.wrap(
        whole, min(columns, MAX_WIDTH), subsequent_indent=indent, break_on_hyphens=False
    )
    return [each.replace(_GLUE, " ") for each in lines]
