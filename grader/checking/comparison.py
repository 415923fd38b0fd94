"""Comparing a submission's answers with the reference's, in the parent.

`Answers` are those to one batch of calls. `expect` compares parts of them, named as C would
write them: "result", "r.tmax", "it.mat.kd". A case is right when its parts are within the
tolerance, relative to their size where that exceeds 1; a NaN never is. The answers of any one
accepted convention will do, and of the cases that are wrong the simplest is shown.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from grader.checking import clues, describe, reproducer
from grader.checking.expected_data import Answer, Array, Batch
from grader.checking.looks import Look
from grader.checking.observations import Observations
from grader.checking.records import Evidence
from grader.course.message import Message

MATERIAL = (
    *("kd", "ks", "shininess", "kr", "refraction_index"),
    *("pattern", "kd2", "pattern_origin", "pattern_size", "user"),
)


class Wrong(Exception):
    """The answer is not right; `message` says what came instead."""

    def __init__(self, key: str, **values: object) -> None:
        super().__init__(key)
        self.message = Message(key, values)
        self.evidence = Evidence()

    def adding(self, then: Iterable[Message]) -> Wrong:
        """Return this error, with sentences behind its own."""
        self.message = replace(self.message, then=tuple(then))
        return self

    def showing(self, evidence: Evidence) -> Wrong:
        """Return this error, with what there is to show beside its sentence."""
        self.evidence = evidence
        return self


@dataclass(frozen=True)
class Answers:
    """A batch, and what the submission answered."""

    batch: Batch
    answer: Answer
    hidden: tuple[str, ...] = ()
    name: str = ""  # in the observations
    observations: Observations = field(default_factory=Observations)
    alone: Callable[[int], Answer | None] | None = None  # makes one of the calls again, by itself

    @property
    def refused(self) -> Array:
        """Which calls the reference answers by false."""
        result = self.batch.answers[0].result
        assert result is not None
        return ~result.astype(bool)

    def aside(self) -> Answers:
        """Return the answers to be tried by, so that nothing is put down of what is wrong."""
        return replace(self, observations=Observations(), alone=None)

    def got(self, pick: str) -> Array:
        """Return a part of the answers."""
        return _part(self.answer, pick)

    def call(self, case: int) -> str:
        """Return the text of a call."""
        return describe.call(self.batch, case, self.hidden)

    def evidence(self, case: int, *looks: Look) -> Evidence:
        """Return the C program that makes a call and looks at what it gives."""
        program = reproducer.of_case(self.batch, case, self.hidden, *looks)
        return Evidence(reproducer=program)

    def simplest(self, wrong: Array) -> int:
        """Return the case that is easiest to follow among those marked."""
        return describe.simplest(self.batch, np.flatnonzero(wrong))

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
        self._note(picks, best[2], where, by)
        case = self.simplest(best[1])
        pick = next(each for each in picks if self._wrong(best[2], [each], by)[case])
        got, right = (by(_part(each, pick)) for each in (self.answer, best[2]))
        wrong = self._wrong(best[2], [pick], by) & best[1]
        look = Look(pick, right[case], self._left(case, pick), unit=by is unit)
        found = self._clues(got, right, wrong)
        if self._is_right_alone(case, pick, right[case : case + 1], by):
            found = [Message("clue.alone")]
        told = self._told(case, pick, got[case], right[case], found)
        raise told.showing(self.evidence(case, look))

    def expect_kept(self, *names: str, where: Array) -> None:
        """Raise Wrong unless what these parameters point to is as it was before the call."""
        for name in names:
            before, after = self.batch.args[name], self.answer.out[name]
            for part in before.dtype.names or ():
                changed = differs(before[part], after[part]) & where
                if changed.any():
                    self.observations.note(f"{self.name} {name}.{part} kept", changed, changed)
                    case = self.simplest(changed)
                    look = self._kept(name, part, case)
                    values = {"call": self.call(case), "what": f"{name}->{part}"}
                    wrong = Wrong("failure.changed", part="changed", **values)
                    raise wrong.showing(self.evidence(case, look))

    def _note(
        self,
        picks: Sequence[str],
        accepted: Answer,
        where: Array | None,
        by: Callable[[Array], Array],
    ) -> None:
        """Put down which parts are wrong."""
        for pick in picks:
            wrong = self._wrong(accepted, [pick], by)
            if where is not None:
                wrong &= where
            name = f"{self.name} {pick}"
            self.observations.note(name, by(self.got(pick)), wrong, self.batch.tolerance)

    def complain(self, wrong: Array, key: str, **values: object) -> None:
        """Raise Wrong at the simplest of the cases marked, if any; the sentence takes `values`.

        A value that is an array gives its item of that case.
        """
        if not wrong.any():
            return
        self.observations.note(f"{self.name} {values.get('what', key)}", wrong, wrong)
        case = self.simplest(wrong)
        own = {
            name: each[case] if isinstance(each, np.ndarray) else each
            for name, each in values.items()
        }
        texts = {
            name: each if isinstance(each, str) else describe.value(each)
            for name, each in own.items()
        }
        looks: tuple[Look, ...] = ()
        if what := texts.get("what", ""):
            pick = what.replace("->", ".")
            looks = (Look(pick, own.get("expected")),)
            texts["part"] = _name(pick)
            if not self._is_written(case, pick):
                key = "failure.not_written"
                texts["expected"] = texts.get("expected", texts.get("position", ""))
        if {"got", "expected"} <= own.keys():
            texts |= describe.pair(own["got"], own["expected"])
        raise Wrong(key, call=self.call(case), **texts).showing(self.evidence(case, *looks))

    def _wrong(self, accepted: Answer, picks: Sequence[str], by: Callable[[Array], Array]) -> Array:
        wrong = np.zeros(self.batch.count, bool)
        for pick in picks:
            wrong |= far(by(self.got(pick)), by(_part(accepted, pick)), self.batch.tolerance)
        return wrong

    def _is_right_alone(
        self, case: int, pick: str, right: Array, by: Callable[[Array], Array]
    ) -> bool:
        """Say whether a call that is wrong gives the right answer when it is the only one."""
        answer = self.alone(case) if self.alone and self.batch.count > 1 else None
        return (
            answer is not None
            and not far(by(_part(answer, pick)), right, self.batch.tolerance).any()
        )

    def _clues(self, got: Array, right: Array, wrong: Array) -> list[Message]:
        """Return what the wrong answers have in common, or the inputs that give them."""
        columns = self.batch.args.values()
        depths = [each["depth"] for each in columns if "depth" in (each.dtype.names or ())]
        found = [clue for each in depths if (clue := clues.deeper(each, wrong))]
        other = None if found else clues.of(got, right, wrong, self.batch.tolerance)
        return [*found, other] if other else found

    def _told(
        self, case: int, pick: str, got: Array, expected: Array, then: Iterable[Message]
    ) -> Wrong:
        name, _, field = pick.partition(".")
        values = {"call": self.call(case), **describe.pair(got, expected)}
        if name == "result":
            is_bool = np.asarray(got).dtype == bool
            part = {"part": values["got"]} if is_bool else {}
            return Wrong("failure.result", **values, **part).adding(then)
        values |= {"what": f"{name}->{field}", "part": _name(pick)}
        if not self._is_written(case, pick):
            return Wrong("failure.not_written", **values)
        return Wrong("failure.output", **values).adding(then)

    def _before(self, pick: str) -> Array:
        return _part(Answer(None, self.batch.args), pick)

    def _is_written(self, case: int, pick: str) -> bool:
        return bool(np.any(self._before(pick)[case] != self.got(pick)[case]))

    def _kept(self, name: str, field: str, case: int) -> Look:
        """Return a look at a part that should be as before the call; of a material, its first."""
        pick = f"{name}.{field}"
        if fields := self._before(pick).dtype.names:
            parts = [f"{pick}.{each}" for each in fields]
            pick = next((each for each in parts if self._is_written(case, each)), parts[0])
        before = self._before(pick)[case]
        return Look(pick, before, before if name in self.hidden else None)

    def _left(self, case: int, pick: str) -> Array | None:
        """Return what stood in an output before the call, when the call has left it there."""
        is_left = pick.partition(".")[0] in self.hidden and not self._is_written(case, pick)
        return self._before(pick)[case] if is_left else None


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
    for inner in fields:
        part = part[inner]
    return np.asarray(part)


def _name(pick: str) -> str:
    """Return the name of a part: that of its field, "material" for all of it."""
    return "material" if ".mat." in pick else pick.rpartition(".")[2]


def differs(before: Array, after: Array) -> Array:
    """Return which rows are not the same bytes."""
    count = len(before)
    sides = [np.frombuffer(each.tobytes(), np.uint8).reshape(count, -1) for each in (before, after)]
    changed: Array = (sides[0] != sides[1]).any(axis=1)
    return changed
