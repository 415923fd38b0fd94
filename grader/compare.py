"""Comparing a submission's answers with the reference's, in the parent.

A `Trial` holds the answers to one batch of calls. `expect` compares parts of them, named as C would
write them: "result", "r.tmax", "it.mat.kd". A case is right when its parts are within the
tolerance, relative to their size where that exceeds 1; a NaN never is. The answers of any one
accepted convention will do, and of the cases that are wrong the simplest is shown.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from grader import show
from grader.expected import Answer, Array, Batch
from grader.records import Evidence, Verdict

MATERIAL = ("kd", "ks", "shininess", "kr", "refraction_index", "pattern", "kd2", "user")


class Wrong(Exception):
    """The answer is not right; `verdict` says what came instead."""

    def __init__(self, key: str, **values: object) -> None:
        super().__init__(key)
        self.verdict = Verdict(key, values)
        self.evidence = Evidence()

    def showing(self, evidence: Evidence) -> Wrong:
        """Return this error, with what there is to show beside its sentence."""
        self.evidence = evidence
        return self


@dataclass(frozen=True)
class Trial:
    """A batch, and what the submission answered."""

    batch: Batch
    answer: Answer
    hidden: tuple[str, ...] = ()

    @property
    def refused(self) -> Array:
        """Which calls the reference answers by false."""
        result = self.batch.answers[0].result
        assert result is not None
        return ~result.astype(bool)

    def got(self, pick: str) -> Array:
        """Return a part of the answers."""
        return _part(self.answer, pick)

    def call(self, case: int) -> str:
        """Return the text of a call."""
        return show.call(self.batch, case, self.hidden)

    def simplest(self, wrong: Array) -> int:
        """Return the case that is easiest to follow among those marked."""
        cases = [int(k) for k in np.flatnonzero(wrong)]
        return min(cases, key=lambda k: show.complexity(self.batch, k))

    def expect(
        self,
        *picks: str,
        where: Array | None = None,
        by: Callable[[Array], Array] = np.asarray,
    ) -> None:
        """Raise Wrong unless the parts are as in the answers of one convention.

        Parameters
        ----------
        picks
            names of parts: "result", "r.tmax"
        where
            which cases count, shape (count,), bool; all of them when it is not given
        by
            what is done to both sides first, such as making directions unit
        """
        best: tuple[int, Array, Answer] | None = None
        for accepted in self.batch.answers:
            wrong = self._wrong(accepted, picks, by)
            if where is not None:
                wrong &= where
            if not wrong.any():
                return
            if best is None or wrong.sum() < best[0]:
                best = int(wrong.sum()), wrong, accepted
        assert best is not None
        case = self.simplest(best[1])
        pick = next(each for each in picks if self._wrong(best[2], [each], by)[case])
        self._complain(case, pick, by(_part(self.answer, pick)), by(_part(best[2], pick)))

    def expect_kept(self, *names: str, where: Array) -> None:
        """Raise Wrong unless what these parameters point to is as it was before the call."""
        for name in names:
            before, after = self.batch.args[name], self.answer.out[name]
            for field in before.dtype.names or ():
                changed = _differs(before[field], after[field]) & where
                if changed.any():
                    case = self.simplest(changed)
                    raise Wrong("failure.changed", call=self.call(case), what=f"{name}->{field}")

    def complain(self, wrong: Array, key: str, **values: object) -> None:
        """Raise Wrong at the simplest of the cases marked, if any; the sentence takes `values`.

        A value that is an array gives its item of that case.
        """
        if not wrong.any():
            return
        case = self.simplest(wrong)
        texts = {
            name: show.value(each[case]) if isinstance(each, np.ndarray) else each
            for name, each in values.items()
        }
        raise Wrong(key, call=self.call(case), **texts)

    def _wrong(self, accepted: Answer, picks: Sequence[str], by: Callable[[Array], Array]) -> Array:
        wrong = np.zeros(self.batch.count, bool)
        for pick in picks:
            wrong |= far(by(self.got(pick)), by(_part(accepted, pick)), self.batch.tolerance)
        return wrong

    def _complain(self, case: int, pick: str, got: Array, expected: Array) -> None:
        name, _, field = pick.partition(".")
        values = {"got": show.value(got[case]), "expected": show.value(expected[case])}
        if name == "result":
            raise Wrong("failure.result", call=self.call(case), **values)
        what = f"{name}->{field}"
        key = "failure.output" if self._is_written(case, pick) else "failure.not_written"
        raise Wrong(key, call=self.call(case), what=what, **values)

    def _is_written(self, case: int, pick: str) -> bool:
        before = Answer(None, self.batch.args)
        return bool(np.any(_part(before, pick)[case] != self.got(pick)[case]))


def far(got: Array, expected: Array, tolerance: float) -> Array:
    """Return which rows differ by more than the tolerance, relative to rows larger than 1.

    Written so that a NaN is far from everything.
    """
    count = len(expected)
    if expected.dtype == bool or expected.dtype.kind in "iu":
        differs: Array = (got != expected).reshape(count, -1).any(axis=1)
        return differs
    a = got.astype(np.float64).reshape(count, -1)
    b = expected.astype(np.float64).reshape(count, -1)
    with np.errstate(invalid="ignore"):
        allowed = tolerance * np.maximum(1.0, np.abs(b).max(axis=1))
        close: Array = np.abs(a - b).max(axis=1) <= allowed
    return ~close


def unit(vectors: Array) -> Array:
    """Return the vectors made unit, shape (n, 3); what has no direction becomes NaN."""
    wide = vectors.astype(np.float64)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        made: Array = wide / np.linalg.norm(wide, axis=-1, keepdims=True)
    return made


def _part(answer: Answer, pick: str) -> Array:
    name, *fields = pick.split(".")
    if name == "result":
        assert answer.result is not None
        return answer.result
    part: Any = answer.out[name]
    for field in fields:
        part = part[field]
    return np.asarray(part)


def _differs(before: Array, after: Array) -> Array:
    """Return which rows are not the same bytes."""
    count = len(before)
    sides = [np.frombuffer(each.tobytes(), np.uint8).reshape(count, -1) for each in (before, after)]
    changed: Array = (sides[0] != sides[1]).any(axis=1)
    return changed
