"""What of a program is compared: the text of each function from TP2 on, and its other functions.

TP1's functions are too short to say anything. Names, numbers, comments, strings and layout are the
first things that a copy changes, so they are left out; calls of the given functions are kept.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache

from grader.course import exercises
from grader.intake import definitions, originals
from grader.setup import c_text

OTHERS = "*"  # the functions that a person has added
_ITEM = re.compile(r"[A-Za-z_]\w*|\.?\d(?:[eEpP][+-]|[\w.])*|->|\+\+|--|&&|\|\||[-+*/%<>=!]=|\S")
_DIRECTIVE = re.compile(r"^[ \t]*#.*$", re.MULTILINE)
_CALLED = re.compile(r"\b([A-Za-z_]\w*)\s*\(")
_KEYWORDS = frozenset(
    """
    auto bool break case char const continue default do double else enum extern false float for
    goto if inline int long register return short signed sizeof static struct switch true
    typedef union unsigned void volatile while
    """.split()  # noqa: SIM905
)


@dataclass(frozen=True)
class Row:
    """A line of a file."""

    file: str
    number: int  # from 1
    text: str


@dataclass(frozen=True)
class Piece:
    """Code that is compared as a whole: its lines, and its items with the line of each."""

    rows: tuple[Row, ...]
    items: tuple[str, ...]
    places: tuple[int, ...]  # by item, the index of its row


def pieces(files: Mapping[str, bytes]) -> dict[str, Piece]:
    """Return the pieces of a program by the name of the function."""
    texts = {name: each.decode(errors="replace") for name, each in files.items()}
    left = {name: text for name, text in texts.items() if name in compared(texts)}
    found = {}
    for function in functions():
        if (own := definitions.find(function, texts)) is None:
            continue
        found[function] = _piece([(own.file, own.line, own.text)])
        if own.file in left:
            blank = "\n" * own.text.count("\n")
            left[own.file] = left[own.file].replace(own.text, blank, 1)
    found[OTHERS] = _piece([(name, 1, text) for name, text in sorted(left.items())])
    return {name: each for name, each in found.items() if each.items}


def compared(names: Iterable[str]) -> list[str]:
    """Return the files of a program in which functions of its own are looked for."""
    first = {each.file for each in exercises.load().exercises if each.tp == 1}
    return [name for name in names if name.endswith(".c") and name not in first]


@cache
def functions() -> dict[str, str]:
    """Return the functions that are compared, with the exercise that asks for each."""
    found: dict[str, str] = {}
    for each in exercises.load().exercises:
        if each.tp > 1:
            found |= {name: found.get(name, each.id) for name in each.functions}
    return found


def _piece(parts: Iterable[tuple[str, int, str]]) -> Piece:
    """Return the piece of texts, each with its file and the number of its first line."""
    rows: list[Row] = []
    items: list[str] = []
    places: list[int] = []
    for file, first, text in parts:
        for number, (line, bare) in enumerate(_lines(text), first):
            if line.strip():
                rows.append(Row(file, number, line))
            for item in _items(bare):
                items.append(item)
                places.append(len(rows) - 1)
    return Piece(tuple(rows), tuple(items), tuple(places))


def _lines(text: str) -> Iterator[tuple[str, str]]:
    """Yield the lines of a text, each with what of it is code."""
    bare = _DIRECTIVE.sub("", c_text.blanked(text))
    return zip(text.split("\n"), bare.split("\n"), strict=True)


def _items(line: str) -> Iterator[str]:
    """Yield what is compared of a line: any name is x, but those that nobody can change."""
    for found in _ITEM.finditer(line):
        item = found[0]
        if item[0].isalpha() or item[0] == "_":
            yield item if item in _KEYWORDS or item in _given_functions() else "x"
        else:
            yield "0" if item.strip(".")[:1].isdigit() else item


@cache
def _given_functions() -> frozenset[str]:
    """Return the functions that are declared in the given headers."""
    rules = exercises.load()
    given = originals.read(in_place=False)
    headers = [given[name].decode() for name in rules.given if name.endswith(".h")]
    called = {name for text in headers for name in _CALLED.findall(c_text.blanked(text))}
    return frozenset(called - _KEYWORDS)
