"""Text as it may stand in a page: nothing that a submission wrote acts, and nothing is hidden."""

from __future__ import annotations

import re
from functools import cache
from typing import Any

from markupsafe import Markup, escape
from pygments import formatters, highlight, lexers  # type: ignore[import-untyped]

from grader.course.texts import Texts

# Controls, and marks that turn the direction of writing: with them a line can look like another.
_HIDDEN = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200b-\u200f\u2028-\u202e\u2060-\u2069\ufeff\ud800-\udfff]"
)
_SPAN = re.compile(r'<span class="(\w+)">([^<]*)</span>')
_STYLED = "kcsm"  # the first letters of the classes that style.css knows
_MEMBER = re.compile(r"\b\w+(?:-&gt;[\w.]+)+")
_NARROW, _WIDE = "\u202f", "\u00a0"


def visible(text: str) -> str:
    """Return the text with its controls spelled out: a bell is <U+0007>."""
    return _HIDDEN.sub(lambda found: f"<U+{ord(found[0]):04X}>", text.replace("\r\n", "\n"))


def typeset(value: Any, language: str) -> Any:
    """Return what a template writes: text made visible, with the spaces of its typography."""
    if not isinstance(value, str) or isinstance(value, Markup):
        return value
    text = visible(value)
    for pattern, bound in _typography(language):
        text = pattern.sub(bound, text)
    return text


@cache
def _typography(language: str) -> tuple[tuple[re.Pattern[str], str], ...]:
    """Return what is bound to the word beside it, and how: keys of [language] in messages/."""
    texts = Texts(language)
    rules = {
        "narrow_before": (r" ([{}])", rf"{_NARROW}\1"),
        "wide_before": (r" ([{}])", rf"{_WIDE}\1"),
        "wide_after": (r"([{}]) ", rf"\1{_WIDE}"),
        "wide_around": (r"(?<=\d) ([{}]) (?=\d)", rf"{_WIDE}\1{_WIDE}"),
    }
    marks = {name: texts.say(f"language.{name}") for name in rules}
    return tuple(
        (re.compile(pattern.format(re.escape(marks[name]))), bound)
        for name, (pattern, bound) in rules.items()
        if marks[name]
    )


def told(text: str, language: str) -> Markup:
    """Return a sentence whose C names, such as r->tmax, stay on one line."""
    sentence = str(escape(typeset(text, language)))
    return Markup(_MEMBER.sub(r'<span class="whole">\g<0></span>', sentence))


def verbatim(text: str) -> Markup:
    """Return text as it was written, such as a compiler's: no typography."""
    return escape(visible(text))


def c_lines(code: str) -> list[Markup]:
    """Return the lines of a C source, its keywords, comments, strings and numbers marked."""
    lexer = lexers.CLexer(stripnl=False, ensurenl=False)
    marked = highlight(visible(code), lexer, formatters.HtmlFormatter(nowrap=True))
    kept = _SPAN.sub(lambda found: found[0] if found[1][0] in _STYLED else found[2], marked)
    return [Markup(line) for line in kept.rstrip("\n").split("\n")]
