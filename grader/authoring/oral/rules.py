"""What a known mistake changes, as a pattern that is looked for in anybody's code.

A rule is a row of marks, some of which the mistake replaces. A mark is either a token of C or a
free one, `$name`, which stands for any operand (a variable, a field, a call), the same at each of
its places. Rules come from the mistakes' patches, where the reference's own variables are free, the
longest context first; and from forms.toml, which has the ways to write a line that the reference
does not use.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from grader.authoring.oral.tokens import CLOSING, FunctionTokens, Token, closing, functions, tokens
from grader.authoring.specimens import mistakes, patches
from grader.authoring.specimens.mistakes import Mistake
from grader.course.exercises import ManifestError, malformed, read_toml

FORMS = Path(__file__).parent / "forms.toml"
LEAST = 3  # tokens of a context, one of them a word that is not free; or so many:
LEAST_FREE = 7
_TYPES = "float|int|bool|vec3|color|point3|ray|intersection|material|object|octree_node|box"
_DECLARED = re.compile(rf"\b(?:{_TYPES}) (?:\* )?(\w+(?: , \w+)*)(?= [=;,[])")
_ENDS = (";", "{", "}")
# The order in which a context grows: what ends an expression, then what ends an argument.
_FENCES = (
    (*_ENDS, ",", "=", "return", "<", ">", "<=", ">=", "==", "&&", "||", "?", ":"),
    (*_ENDS, ","),
    _ENDS,
)
_SWAPPED = ("vector_add", "vector_dot", "vector_vec_mul", "fmax", "fmin")


@dataclass(frozen=True)
class RuleMark:
    """A place of a pattern: a token, or a free one by its name; `changed` is what is replaced."""

    token: Token
    free: str = ""
    changed: bool = False


@dataclass(frozen=True)
class Rule:
    """A mistake as a change of code: the marks of what stands there, and what replaces them.

    `parameters` are those of the function that the free names come from, in order; a form has none.
    """

    mistake: Mistake
    marks: tuple[RuleMark, ...]
    new: tuple[RuleMark, ...]
    parameters: tuple[str, ...] = ()


def of(mistake: Mistake) -> Iterator[Rule]:
    """Yield the rules of a mistake, from the surest to the least. Raises ManifestError."""
    seen = set()
    for rule in (*_from_patch(mistake), *_from_forms(mistake)):
        for marks in _swaps(rule.marks):
            key = tuple((each.token.key, each.free, each.changed) for each in marks)
            if key not in seen:
                seen.add(key)
                yield Rule(mistake, marks, rule.new, rule.parameters)


@cache
def forms() -> dict[str, list[tuple[str, str]]]:
    """Read forms.toml: by mistake, what stands there and what it becomes. Raises ManifestError."""
    table = read_toml(FORMS)
    known = {each.id for each in mistakes.load()}
    try:
        found = {name: [(old, new) for old, new in rows] for name, rows in table["form"].items()}
    except (KeyError, TypeError, ValueError) as error:
        raise malformed(FORMS, error) from error
    if unknown := sorted(set(found) - known):
        raise ManifestError(f"{FORMS.name}: {unknown[0]} is no known mistake")
    return found


# ---- From forms ---------------------------------------------------------------------------------


def _from_forms(mistake: Mistake) -> Iterator[Rule]:
    for old, new in forms().get(mistake.id, []):
        before, after = tokens(old), tokens(new)
        begin, end = _difference(before, after)
        changed = range(begin, len(before) - end)
        yield Rule(
            mistake,
            tuple(_mark(each, k in changed) for k, each in enumerate(before)),
            tuple(_mark(each) for each in after[begin : len(after) - end]),
        )


def _mark(token: Token, changed: bool = False, free: frozenset[str] = frozenset()) -> RuleMark:
    name = token.text if token.text.startswith("$") or token.text in free else ""
    return RuleMark(token, name, changed)


# ---- From the patch -----------------------------------------------------------------------------


def _from_patch(mistake: Mistake) -> Iterator[Rule]:
    before, after = patches.reference(), mistake.files()
    for name, text in before.items():
        if text == after[name]:
            continue
        old, new = functions(text), functions(after[name])
        for key, function in old.items():
            if key in new and _keys(function) != _keys(new[key]):
                yield from _contexts(mistake, function, new[key])


def _keys(function: FunctionTokens) -> list[str]:
    return [each.key for each in function.body]


def _contexts(mistake: Mistake, old: FunctionTokens, new: FunctionTokens) -> Iterator[Rule]:
    begin, end = _difference(old.body, new.body)
    stop = len(old.body) - end
    free = frozenset((*old.parameters, *_locals(old.body)))
    added = tuple(_free(new.body, begin, len(new.body) - end, begin, 0, free))
    spans = list(_grown(old.body, begin, stop))
    for first, last in reversed(spans):
        marks = tuple(_free(old.body, first, last, begin, stop, free))
        if _is_telling(marks):
            yield Rule(mistake, marks, added, old.parameters)


def _free(
    row: Sequence[Token], first: int, last: int, begin: int, stop: int, free: frozenset[str]
) -> Iterator[RuleMark]:
    """Yield a part of a row as marks; a field is never free."""
    for k in range(first, last):
        is_field = k > 0 and row[k - 1].text in (".", "->")
        yield _mark(row[k], begin <= k < stop, frozenset() if is_field else free)


def _difference(old: Sequence[Token], new: Sequence[Token]) -> tuple[int, int]:
    """Return how many tokens two rows share at their beginning, and at their end."""
    shortest = min(len(old), len(new))
    begin = 0
    while begin < shortest and old[begin].text == new[begin].text:
        begin += 1
    end = 0
    while end < shortest - begin and old[-1 - end].text == new[-1 - end].text:
        end += 1
    if begin + end == len(old) and begin:  # something is put in: after the token before it
        begin -= 1
    return begin, end


def _locals(body: Sequence[Token]) -> Iterator[str]:
    """Yield the names that a body of the reference declares."""
    for names in _DECLARED.findall(" ".join(each.text for each in body)):
        yield from names.split(" , ")


def _grown(row: Sequence[Token], begin: int, stop: int) -> Iterator[tuple[int, int]]:
    """Yield spans around a change, each wider than the one before, up to its whole statement."""
    begin, stop = _balanced(row, begin, stop)
    for fence in _FENCES:
        while True:
            begin, stop = _between(row, begin, stop, fence)
            if stop > begin:
                yield begin, stop
            if row[begin - 1].text not in "([" or row[stop].text not in ")]":
                break
            begin, stop = begin - 1, stop + 1
            while begin > 1 and row[begin - 1].kind == "name" and row[begin - 1].text != "return":
                begin -= 1
    if row[stop].text == ";":
        yield begin, stop + 1


def _balanced(row: Sequence[Token], begin: int, stop: int) -> tuple[int, int]:
    """Return the smallest span around one that closes what it opens."""
    while begin > 0 and _depth(row[begin:stop])[1] < 0:
        begin -= 1
    while stop < len(row) and _depth(row[begin:stop])[0] > 0:
        stop += 1
    return begin, stop


def _depth(row: Sequence[Token]) -> tuple[int, int]:
    """Return the depth at the end of a row, and the lowest on the way."""
    depth = lowest = 0
    for token in row:
        depth += (token.text in CLOSING) - (token.text in CLOSING.values())
        lowest = min(lowest, depth)
    return depth, lowest


def _between(row: Sequence[Token], begin: int, stop: int, fence: Sequence[str]) -> tuple[int, int]:
    """Return the widest span around one that holds no fence and no open bracket."""
    depth = 0
    while begin > 1:
        text = row[begin - 1].text
        depth += (text in CLOSING.values()) - (text in CLOSING)
        if depth < 0 or (depth == 0 and text in fence):
            break
        begin -= 1
    depth = 0
    while stop < len(row) - 1:
        text = row[stop].text
        depth += (text in CLOSING) - (text in CLOSING.values())
        if depth < 0 or (depth == 0 and text in fence):
            break
        stop += 1
    return begin, stop


def _is_telling(marks: Sequence[RuleMark]) -> bool:
    words = [each for each in marks if each.token.kind == "name" and not each.free]
    return len(marks) >= (LEAST if words else LEAST_FREE)


def _swaps(marks: tuple[RuleMark, ...]) -> Iterator[tuple[RuleMark, ...]]:
    """Yield the marks, and once more for each call in them whose two arguments may be exchanged."""
    yield marks
    row = [each.token for each in marks]
    for k, token in enumerate(row[:-1]):
        if token.key in _SWAPPED and row[k + 1].text == "(":
            end = closing(row, k + 1)
            comma = next((n for n in range(k + 2, end) if _is_comma(row, k + 2, n)), end)
            first, second = marks[k + 2 : comma], marks[comma + 1 : end]
            swapped = (*marks[: k + 2], *second, marks[min(comma, end - 1)], *first, *marks[end:])
            if second and _is_whole(swapped):
                yield swapped


def _is_comma(row: Sequence[Token], start: int, at: int) -> bool:
    return row[at].text == "," and _depth(row[start:at])[0] == 0


def _is_whole(marks: Sequence[RuleMark]) -> bool:
    """Say whether what is changed still stands together."""
    return "".join("x" if each.changed else " " for each in marks).strip().count(" ") == 0
