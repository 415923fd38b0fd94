"""What two programs share beyond what everybody writes.

Left out is what also stands in the skeleton or in one of the usual ways, right programs that were
written for the course. What many programs of a class share weighs little: a run that only two have
counts whole, one that all have next to nothing.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field
from itertools import groupby

from grader.authoring.alike.pieces import Piece
from grader.authoring.alike.tools import Items, Tool

Program = Mapping[str, Piece]
LEAST_LEFT = 6  # items of a stretch, once the usual is left out


@dataclass(frozen=True)
class Shared:
    """What two programs share in a piece: the items of each, and their weight."""

    items: frozenset[int]
    other_items: frozenset[int]
    weight: float


@dataclass
class Pair:
    """Two programs by their indices, and what they share in each piece."""

    one: int
    other: int
    parts: dict[str, Shared] = field(default_factory=dict)

    @property
    def weight(self) -> float:
        """How much they share, in items."""
        return sum(each.weight for each in self.parts.values())


def pairs(
    programs: Sequence[Program], usual: Sequence[Program], tool: Tool, past: int = 0
) -> list[Pair]:
    """Return the pairs that share something, those that share most first.

    The last `past` programs are of earlier years: they are compared with the others alone.
    """
    found: dict[tuple[int, int], Pair] = {}
    recent = len(programs) - past
    for name in sorted({name for each in programs for name in each}):
        owners = [k for k, each in enumerate(programs) if name in each]
        known = {each[name].items for each in usual if name in each}
        texts = [programs[k][name].items for k in owners]
        for (a, b), shared in _shared(texts, sorted(known), tool, len(programs)):
            one, other = owners[a], owners[b]
            if one < recent:
                pair = found.setdefault((one, other), Pair(one, other))
                pair.parts[name] = shared
    return sorted(found.values(), key=lambda each: (-each.weight, each.one, each.other))


def _shared(
    texts: Sequence[Items], usual: Sequence[Items], tool: Tool, count: int
) -> Iterator[tuple[tuple[int, int], Shared]]:
    """Yield what the texts of a piece share, two by two."""
    everybody: defaultdict[int, set[int]] = defaultdict(set)
    common: defaultdict[tuple[int, int], set[int]] = defaultdict(set)
    for run in tool([*texts, *usual], len(texts)):
        if run.other >= len(texts):
            everybody[run.one].update(run.items)
        else:
            common[run.one, run.other].update(run.items)
            common[run.other, run.one].update(run.other_items)
    left = {key: _stretches(items - everybody[key[0]]) for key, items in common.items()}
    spread: defaultdict[int, Counter[int]] = defaultdict(Counter)
    for (one, _), items in left.items():
        spread[one].update(items)
    for (one, other), items in left.items():
        if one < other and (items or left[other, one]):
            weights = [
                sum(_weight(spread[own][item] + 1, count) for item in left[own, its])
                for own, its in ((one, other), (other, one))
            ]
            yield (one, other), Shared(items, left[other, one], sum(weights) / 2)


def _stretches(items: Set[int]) -> frozenset[int]:
    """Return the items that stand beside enough others."""
    kept: set[int] = set()
    for _, group in groupby(enumerate(sorted(items)), key=lambda each: each[1] - each[0]):
        stretch = [item for _, item in group]
        if len(stretch) >= LEAST_LEFT:
            kept.update(stretch)
    return frozenset(kept)


def _weight(sharers: int, count: int) -> float:
    """Return what an item weighs that so many of the programs have: 1 for two of them."""
    return math.log((count + 1) / sharers) / math.log((count + 1) / 2)
