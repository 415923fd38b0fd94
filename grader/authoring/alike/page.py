"""alike.html, the pairs with both sides, and alike.json, which the class page lists them from."""

from __future__ import annotations

import statistics
from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grader.authoring.alike.pieces import OTHERS, Piece, functions
from grader.authoring.alike.sharing import Pair, Program, pairs
from grader.authoring.alike.tools import Tool
from grader.batch.alike_list import MOST
from grader.course.texts import Texts
from grader.report import page

TEMPLATES = Path(__file__).parent / "templates"
AROUND = 2  # lines shown around those that are shared, among the functions that a person has added


@dataclass(frozen=True)
class Compared:
    """A class that was compared: its pairs, those that share most first.

    `names` are those of the programs, each with its pseudonym; the last `past` programs are of
    earlier years. `apart` is the most lines that programs share which were written independently.
    """

    names: Sequence[tuple[str, str]]
    programs: Sequence[Program]
    pairs: Sequence[Pair]
    apart: int
    past: int
    tool: str


def as_json(compared: Compared) -> dict[str, Any]:
    """Return the most alike pairs, by names and pseudonyms."""
    sides = ("name", "pseudonym")
    return {
        "pairs": [
            {
                "one": dict(zip(sides, compared.names[each.one], strict=True)),
                "other": dict(zip(sides, compared.names[each.other], strict=True)),
                "lines": lines(each, compared.programs),
                "exercises": _exercises(each),
            }
            for each in compared.pairs[:MOST]
        ]
    }


def lines(pair: Pair, programs: Sequence[Program]) -> int:
    """Return how many lines two programs share; of the one that needs fewer for them."""
    sides = ((pair.one, "items"), (pair.other, "other_items"))
    return min(
        sum(len(_rows(programs[k][name], getattr(part, side))) for name, part in pair.parts.items())
        for k, side in sides
    )


def most_lines(programs: Sequence[Program], usual: Sequence[Program], tool: Tool) -> int:
    """Return how many lines the programs of a set share at most, two by two."""
    found = pairs(programs, usual, tool)
    return max((lines(each, programs) for each in found), default=0)


def _rows(piece: Piece, items: Set[int]) -> set[int]:
    return {piece.places[item] for item in items}


def _exercises(pair: Pair) -> list[str]:
    """Return the exercises in which a pair shares something, in the course's order."""
    found = [exercise for name, exercise in functions().items() if name in pair.parts]
    return sorted(dict.fromkeys(found))


def render(compared: Compared, names: bool, texts: Texts) -> str:
    """Return the page; without `names` it has pseudonyms."""
    made = page.environment(texts, TEMPLATES, "alike.css")
    return made.get_template("alike.html").render(
        count=len(compared.programs) - compared.past,
        past=compared.past,
        tool=compared.tool,
        median=round(statistics.median(_of_all(compared))),
        apart=compared.apart,
        pairs=[_shown(each, compared, names) for each in compared.pairs[:MOST]],
    )


def _of_all(compared: Compared) -> list[int]:
    """Return the lines that each pair of the class shares, none included."""
    recent = len(compared.programs) - compared.past
    found = [lines(each, compared.programs) for each in compared.pairs]
    # Two programs of earlier years are no pair.
    every = recent * (recent - 1) // 2 + recent * compared.past
    return found + [0] * max(every - len(found), 0)


def _shown(pair: Pair, compared: Compared, names: bool) -> dict[str, Any]:
    """Return what the template shows of a pair."""
    label = 0 if names else 1
    order = sorted(pair.parts, key=lambda name: -pair.parts[name].weight)
    one, other = compared.programs[pair.one], compared.programs[pair.other]
    return {
        "one": compared.names[pair.one][label],
        "other": compared.names[pair.other][label],
        "lines": lines(pair, compared.programs),
        "exercises": _exercises(pair),
        "parts": [
            {
                "function": "" if name == OTHERS else name,
                "exercise": functions().get(name, ""),
                "sides": [
                    [*_side(one[name], pair.parts[name].items, name == OTHERS)],
                    [*_side(other[name], pair.parts[name].other_items, name == OTHERS)],
                ],
            }
            for name in order
        ],
    }


def _side(piece: Piece, items: Set[int], short: bool) -> Iterator[dict[str, Any]]:
    """Yield the lines of a piece, with those that are shared; `short`: these and a few around."""
    marked = _rows(piece, items)
    for k, row in enumerate(piece.rows):
        near = range(k - AROUND, k + AROUND + 1)
        if not short or not marked.isdisjoint(near):
            yield {"number": row.number, "text": row.text, "marked": k in marked}
