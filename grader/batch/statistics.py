"""What the class page tells of a class: numbers only, from the summaries of the results."""

from __future__ import annotations

import statistics
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from grader.batch.records import Graded, Mark
from grader.course import exercises as manifest
from grader.course.texts import Texts
from grader.evaluation.records import Outcome

HARDEST = 10
MISTAKES = 10
_TRIED = ("passed", "failed", "crashed", "timeout")


@dataclass(frozen=True)
class ExerciseStatistics:
    """How a class does in one exercise."""

    id: str
    title: str
    bonus: bool
    share: float  # of its points, on average, from 0 to 1
    outcomes: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True)
class CheckStatistics:
    """How often a check passes among those who have tried."""

    id: str
    exercise: str
    passed: int
    tried: int


@dataclass(frozen=True)
class ClassStatistics:
    """A class in numbers. `bins` count the marks from k to k + 1, the scale with the last."""

    submissions: int
    mean: float | None
    median: float | None
    deviation: float | None
    bins: Sequence[int]
    exercises: Sequence[ExerciseStatistics]
    hardest: Sequence[CheckStatistics]
    mistakes: Sequence[tuple[str, int]]
    crashes: int
    timeouts: int
    not_compiled: int
    seconds: float  # of the median submission
    cpu: float  # of all of them


def of(
    marks: Sequence[Mark], graded: Mapping[str, Graded], scale: float, texts: Texts
) -> ClassStatistics:
    """Return the numbers of a class."""
    values = [each.value for each in marks if each.value is not None and not each.error]
    known = [each for each in graded.values() if each.results]
    results = [each.results for each in known if each.results]
    checks = Counter(outcome for each in results for outcome in each["checks"].values())
    mistakes = Counter(name for each in results for name in each["mistakes"])
    return ClassStatistics(
        submissions=len(graded),
        mean=statistics.fmean(values) if values else None,
        median=statistics.median(values) if values else None,
        deviation=statistics.pstdev(values) if values else None,
        bins=_bins(values, scale),
        exercises=_exercises([each["exercises"] for each in results], texts),
        hardest=_hardest([each["checks"] for each in results]),
        mistakes=mistakes.most_common(MISTAKES),
        crashes=checks[Outcome.CRASHED.value],
        timeouts=checks[Outcome.TIMEOUT.value],
        not_compiled=sum(not each["compiles"] for each in results),
        seconds=statistics.median([each.seconds for each in known]) if known else 0.0,
        cpu=sum(each.cpu for each in known),
    )


def _bins(values: Sequence[float], scale: float) -> list[int]:
    count = max(1, min(20, round(scale)))
    found = [0] * count
    for value in values:
        found[min(int(value * count / scale), count - 1)] += 1
    return found


def _exercises(
    results: Sequence[Mapping[str, Sequence[object]]], texts: Texts
) -> list[ExerciseStatistics]:
    found = []
    for each in manifest.load().exercises:
        own = [result[each.id] for result in results if each.id in result]
        if not own or not each.points:  # the drawing of one's own earns none
            continue
        earned = sum(float(str(row[1])) for row in own)
        most = sum(float(str(row[2])) for row in own)
        outcomes = Counter(str(row[0]) for row in own)
        found.append(
            ExerciseStatistics(each.id, texts.title(each), each.bonus, earned / most, outcomes)
        )
    return found


def _hardest(results: Sequence[Mapping[str, str]]) -> list[CheckStatistics]:
    found = []
    for name, check in manifest.load().checks().items():
        tried = [result[name] for result in results if result.get(name) in _TRIED]
        passed = tried.count(Outcome.PASSED.value)
        if passed < len(tried):
            found.append(CheckStatistics(name, check.exercise, passed, len(tried)))
    return sorted(found, key=lambda each: (each.passed / each.tried, -each.tried))[:HARDEST]
