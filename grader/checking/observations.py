"""What a check saw of a submission's answers and found wrong: what a diagnosis is made from.

The checks note every part of the answers that is not right, by a name that is the same in every
run, before they complain about its simplest case. Two submissions with the same observations in all
the checks of an exercise have made the same mistake there, or mistakes that no check tells apart.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]


@dataclass(frozen=True)
class Observation:
    """The wrong cases of one part of the answers.

    `cases` are their numbers, shape (n,); `values` what was answered there, shape (n, k), float32.
    """

    cases: Array
    values: Array
    tolerance: float = 0.0

    def agrees(self, other: Observation) -> bool:
        """Say whether the same cases are wrong, with the same answers within the tolerance.

        The tolerance is relative to answers that exceed 1. A NaN agrees with a NaN.
        """
        if self.values.shape != other.values.shape or (self.cases != other.cases).any():
            return False
        a, b = (each.values.astype(np.float64) for each in (self, other))
        scale = np.nan_to_num(np.maximum(1.0, np.abs(b)), posinf=1.0)
        with np.errstate(invalid="ignore"):
            close = np.abs(a - b) <= self.tolerance * scale.max(axis=1, keepdims=True, initial=1.0)
        return bool((close | (a == b) | (np.isnan(a) & np.isnan(b))).all())


class Observations:
    """The wrong parts of one check, by their names; of a picture, which it was besides."""

    def __init__(self) -> None:
        self.parts: dict[str, Observation] = {}
        self.pictures: list[str] = []  # the expected ones that were looked at
        self.candidates: list[str] = []  # ids of known mistakes that may explain what is wrong
        self._batches = 0

    def next_batch(self) -> str:
        """Return a name for what is asked next: its number in the check."""
        self._batches += 1
        return str(self._batches)

    def note(self, name: str, got: Array, wrong: Array, tolerance: float = 0.0) -> None:
        """Note a part of the answers; nothing when none of it is wrong.

        Parameters
        ----------
        got
            the answers, one row for each case; numbers or bools
        wrong
            which cases are wrong, shape (cases,), bool
        tolerance
            within which another submission's answers are the same
        """
        cases = np.flatnonzero(wrong)
        if len(cases):
            # An answer may exceed what a float32 holds.
            with np.errstate(over="ignore"):
                values = np.asarray(got)[cases].reshape(len(cases), -1).astype(np.float32)
            self.parts[name] = Observation(cases, values, tolerance)

    def look_at(self, picture: str, candidates: Iterable[str] = ()) -> None:
        """Put down which expected picture was looked at, and the mistakes that may explain it."""
        self.pictures.append(picture)
        self.candidates += candidates

    def note_mask(self, name: str, mask: Array) -> None:
        """Note a mask of a picture by its digest, unless it is empty."""
        digest = hashlib.sha256(np.packbits(mask).tobytes()).digest()[:8]
        self.note(name, np.frombuffer(digest, np.uint8)[None], np.array([mask.any()]))
