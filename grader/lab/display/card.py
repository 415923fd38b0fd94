"""What a cell shows besides pictures: a card, a table; as HTML, and as plain text without it."""

from __future__ import annotations

import html
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

# Seen on light ground and on dark; JupyterLab's own are too pale on white.
_EDGES = {"plain": "#808080", "good": "#0072b2", "bad": "#d55e00"}
_CARD = "border-left:4px solid {edge};padding:.4em .8em;margin:.4em 0;max-width:60em"
_CELL = (
    "text-align:left;padding:.15em .7em .15em 0;vertical-align:top;max-width:34em;"
    "overflow-wrap:anywhere"  # where there is little room, rather than a second scroll bar
)
_HEAD = f"{_CELL};min-width:min(5.5em,7vw)"  # a column's name is whole where there is room
_PRE = (
    "font-family:var(--jp-code-font-family, monospace);"
    "white-space:pre;overflow-x:auto;margin:.4em 0"
)


# A word of the language: neither a symbol (t, d.n, max_depth) nor a value of C's.
_LETTER = r"[^\W\d_A-Z]"
_WORD = re.compile(
    rf"(?!true\b|false\b|out->){_LETTER}{{2}}(?:{_LETTER}+(?![\w.(=])| [^\W\d_]{{2}})"
)


@dataclass(frozen=True)
class Shown:
    """Something that a cell shows: `html`, and `text` where there is no HTML."""

    html: str
    text: str

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, str]:
        """Return what Jupyter chooses from."""
        return {"text/html": self.html, "text/plain": self.text}

    def __repr__(self) -> str:
        return self.text


def escape(text: object) -> str:
    """Return a text as HTML that shows it as it is."""
    return html.escape(str(text))


def capital(text: str) -> str:
    """Return a title with a capital, where it begins with a word."""
    return text[:1].upper() + text[1:] if _WORD.match(text) else text


def card(inside: str, text: str, tone: str = "plain") -> Shown:
    """Return a card of HTML `inside`; `tone` is plain, good or bad."""
    style = _CARD.format(edge=_EDGES[tone])
    return Shown(f'<div style="{style}">{inside}</div>', text)


def note(sentence: str, tone: str = "plain") -> Shown:
    """Return a card with one sentence."""
    return card(escape(sentence), sentence, tone)


def code(text: str) -> str:
    """Return HTML of lines of code or of a compiler, as they are."""
    return f'<pre class="mrt-code" style="{_PRE}">{escape(text)}</pre>'


def fold(title: str, inside: str) -> str:
    """Return HTML that shows `inside` when its title is clicked."""
    return f"<details><summary>{escape(title)}</summary>{inside}</details>"


def table(heads: Sequence[str], rows: Sequence[Sequence[Shown | str]]) -> Shown:
    """Return a table; a cell is a text, or something shown."""
    lines = [heads, *rows] if any(heads) else list(rows)
    plain = [[each.text if isinstance(each, Shown) else each for each in row] for row in lines]
    widths = [max(len(row[k]) for row in plain) for k in range(len(heads))]
    text = "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in plain
    )
    head = "".join(f'<th scope="col" style="{_HEAD}">{escape(each)}</th>' for each in heads)
    body = "".join(
        "<tr>" + "".join(f'<td style="{_CELL}">{_cell(each)}</td>' for each in row) + "</tr>"
        for row in rows
    )
    top = f"<thead><tr>{head}</tr></thead>" if any(heads) else ""
    return Shown(f"<table>{top}<tbody>{body}</tbody></table>", text)


def stack(parts: Sequence[Shown]) -> Shown:
    """Return several things, one below the other."""
    return Shown("".join(each.html for each in parts), "\n\n".join(each.text for each in parts))


def _cell(cell: Shown | str) -> str:
    """Return the HTML of a cell; a name of C is broken at its underscores first."""
    return cell.html if isinstance(cell, Shown) else escape(cell).replace("_", "_<wbr>")
