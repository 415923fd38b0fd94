"""C as a row of tokens that know where they stand: enough to find a line again in other words."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

_TOKEN = re.compile(
    r"""(?P<skip>\s+|/\*.*?\*/|//[^\n]*|^[ \t]*\#(?:\\\n|[^\n])*)
    |(?P<number>(?:0[xX][0-9a-fA-F]+|(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)[uUlLfF]*)
    |(?P<name>\$?[A-Za-z_]\w*)
    |(?P<text>"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*')
    |(?P<sign>->|\+\+|--|<<=|>>=|<=|>=|==|!=|&&|\|\||<<|>>|[-+*/%&|^]=|.)""",
    re.VERBOSE | re.DOTALL | re.MULTILINE,
)
# Words that students choose freely, and the one that stands for them when texts are compared.
_SAME = {
    **dict.fromkeys(("color", "point3"), "vec3"),
    **dict.fromkeys(("double",), "float"),
    **dict.fromkeys(("M_PI", "M_PIf", "pi", "Pi"), "PI"),
    **{f"{name}f": name for name in ("fabs", "sqrt", "pow", "tan", "floor", "fmin", "fmax")},
}
_PI = "3.14159"
CLOSING = {"(": ")", "[": "]", "{": "}"}


@dataclass(frozen=True)
class Token:
    """A token: as it is written, as it is compared, and where it stands in the text."""

    text: str
    key: str
    kind: str  # number, name, text or sign
    start: int
    end: int


@dataclass(frozen=True)
class FunctionTokens:
    """A function's definition: its parameters' names, and its body's tokens, braces included.

    `start` is where its name stands in the text; `closed` has, for each token of the body that
    opens a bracket, the index of the one that closes it, and the token's own for the others.
    """

    name: str
    start: int
    parameters: tuple[str, ...]
    body: tuple[Token, ...]
    closed: tuple[int, ...]


def tokens(text: str) -> list[Token]:
    """Return the tokens of C code, without comments and preprocessor lines."""
    found = []
    for match in _TOKEN.finditer(text):
        kind = match.lastgroup or "sign"
        if kind != "skip":
            found.append(Token(match[0], _key(match[0], kind), kind, *match.span()))
    return found


def closing(row: Sequence[Token], start: int) -> int:
    """Return the index of the bracket that closes the one at `start`; the row's end without one."""
    depth = 0
    for k in range(start, len(row)):
        depth += (row[k].text in CLOSING) - (row[k].text in CLOSING.values())
        if depth == 0:
            return k
    return len(row)


def functions(text: str) -> dict[str, FunctionTokens]:
    """Return the functions that a C file defines, by their names."""
    row, found = tokens(text), {}
    k = 0
    while k < len(row):
        end = closing(row, k)
        is_head = row[k].text == "(" and k > 0 and row[k - 1].kind == "name"
        if is_head and end + 1 < len(row) and row[end + 1].text == "{":
            last = closing(row, end + 1)
            body, head = tuple(row[end + 1 : last + 1]), row[k - 1]
            names = _parameters(row[k + 1 : end])
            found[head.text] = FunctionTokens(head.text, head.start, names, body, _closed(body))
            end = last
        k = end + 1 if row[k].text in CLOSING else k + 1
    return found


def _closed(row: Sequence[Token]) -> tuple[int, ...]:
    found = list(range(len(row)))
    opened: list[int] = []
    for k, token in enumerate(row):
        if token.text in CLOSING:
            opened.append(k)
        elif token.text in CLOSING.values() and opened:
            found[opened.pop()] = k
    return tuple(found)


def _parameters(row: Sequence[Token]) -> tuple[str, ...]:
    """Return the last name before each comma."""
    names, last = [], ""
    for token in row:
        if token.text == ",":
            names.append(last)
        elif token.kind == "name":
            last = token.text
    return (*names, last) if row else ()


def _key(text: str, kind: str) -> str:
    if kind == "number":
        if text.startswith(_PI):
            return "PI"
        if text[:2].lower() == "0x":
            return str(int(text.rstrip("uUlL"), 16))
        return f"{float(text.rstrip('uUlLfF')):g}"
    return _SAME.get(text, text)
