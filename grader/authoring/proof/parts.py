"""What each part of the proof gives: figures, faults, and lines for the page. No I/O."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

SEED = 8  # of what is drawn by lot: pairs, and samples

T = TypeVar("T")


@dataclass(frozen=True)
class Part:
    """One part of the proof.

    `faults` are lines that say what is not as it should be; `rows` are for the page, under `heads`.
    """

    name: str
    title: str
    figures: dict[str, float]
    faults: list[str]
    heads: list[str] = field(default_factory=list)
    rows: list[list[str]] = field(default_factory=list)
    whole: bool = True  # not a sample


def sampled(items: Sequence[T], size: int | None) -> list[T]:
    """Return that many items drawn by a fixed lot, in their order; all of them when None."""
    if size is None or size >= len(items):
        return list(items)
    chosen = np.random.default_rng(SEED).permutation(len(items))[:size]
    return [items[k] for k in sorted(chosen)]


def listed(names: object) -> str:
    """Return names with commas between them."""
    assert isinstance(names, (list, tuple, set, frozenset))
    return ", ".join(sorted(names))
