"""Two mistakes at once: both lose points, no third is named, and mending one never costs any."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from grader.authoring.proof import known
from grader.authoring.proof.grades import Grade, GradeCache, Program
from grader.authoring.proof.parts import SEED, Part, listed
from grader.authoring.specimens import mistakes
from grader.authoring.specimens.mistakes import Mistake
from grader.authoring.specimens.patches import PatchError

PAIRS = 100
_SLACK = 1e-6  # of points, which are sums of hundredths


@dataclass(frozen=True)
class Pair:
    """Two mistakes in different exercises, and the reference with both."""

    one: Mistake
    other: Mistake
    files: Mapping[str, str]

    @property
    def id(self) -> str:
        """Both names."""
        return f"{self.one.id} + {self.other.id}"

    @property
    def program(self) -> Program:
        """What is graded."""
        return Program(self.id, self.files)


def drawn(count: int = PAIRS, seed: int = SEED) -> list[Pair]:
    """Draw pairs of mistakes in different exercises; those that change the same line are left."""
    candidates = list(combinations(mistakes.load(), 2))
    pairs: list[Pair] = []
    for k in np.random.default_rng(seed).permutation(len(candidates)):
        one, other = candidates[k]
        if one.exercise != other.exercise and (files := both(one, other)):
            pairs.append(Pair(one, other, files))
        if len(pairs) == count:
            break
    return pairs


def both(one: Mistake, other: Mistake) -> dict[str, str]:
    """Return the reference with two mistakes in it; {} where they do not go together."""
    try:
        return other.files(one.files())
    except PatchError:
        return {}


def run(grade_cache: GradeCache, sample: int | None = None) -> Part:
    """Grade pairs, and each mistake alone. Raises ProofError."""
    pairs = drawn(PAIRS if sample is None else sample)
    programs = {each.id: each.program for each in pairs}
    for pair in pairs:
        programs |= {each.id: known.program(each) for each in (pair.one, pair.other)}
    grades = {each.id: grade for each, grade in grade_cache.graded(programs.values())}
    return report(pairs, grades, sample is None)


def report(pairs: Sequence[Pair], grades: Mapping[str, Grade], whole: bool = True) -> Part:
    """Return the part of the proof from the grades of pairs and of single mistakes, by id."""
    silent = [_silent(each, grades[each.id]) for each in pairs]
    thirds = [_thirds(each, grades[each.id]) for each in pairs]
    lowered = [_lowered(each, grades) for each in pairs]
    return Part(
        "pairs",
        "Pairs of mistakes, and what mending one of them does",
        {
            "pairs": len(pairs),
            "pairs_caught": sum(not each for each in silent),
            "pairs_third_named": sum(map(bool, thirds)),
            "mendings": 2 * len(pairs),
            "mendings_lowered": sum(map(len, lowered)),
        },
        [fault for group in (*silent, *thirds, *lowered) for fault in group],
        ["pair", "exercises", "points lost", "named"],
        [
            [
                each.id,
                f"{each.one.exercise}, {each.other.exercise}",
                f"{grades[each.id].missing:.2f}",
                listed({name for names in grades[each.id].named.values() for name in names}),
            ]
            for each in pairs
        ],
        whole,
    )


def _silent(pair: Pair, grade: Grade) -> list[str]:
    """Return the mistakes that lose nothing, a line each."""
    quiet = [each for each in (pair.one, pair.other) if each.exercise not in grade.losing]
    return [f"{pair.id}: {each.id} loses nothing in {each.exercise}" for each in quiet]


def _thirds(pair: Pair, grade: Grade) -> list[str]:
    """Return the lines on what is named and is not there.

    Twins of a mistake are named with it, never without.
    """
    accepted = [{each.id, *each.twins} for each in (pair.one, pair.other)]
    there = {pair.one.id, pair.other.id}
    return [
        f"{pair.id}: {check} names {listed(names)}"
        for check, names in grade.named.items()
        if not any(set(names) <= each and there & set(names) for each in accepted)
    ]


def _lowered(pair: Pair, grades: Mapping[str, Grade]) -> list[str]:
    """Return where mending one of the two costs points, a line each."""
    before = grades[pair.id]
    lines = []
    for mended, left in ((pair.one, pair.other), (pair.other, pair.one)):
        after = grades[left.id]
        worse = [
            name for name in before.points if after.points[name] < before.points[name] - _SLACK
        ]
        if worse:
            lines.append(f"{pair.id}: mending {mended.id} costs points in {listed(worse)}")
    return lines
