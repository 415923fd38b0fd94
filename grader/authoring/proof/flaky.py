"""The same submission gives the same results: again and again, and on a busy machine."""

from __future__ import annotations

import contextlib
import json
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any

from grader.authoring.proof import known, load, nothing, solver
from grader.authoring.proof.grades import GradeCache, Program
from grader.authoring.proof.parts import Part
from grader.authoring.specimens import mistakes, patches
from grader.files import content_key
from grader.report.results import write

RUNS = 200  # of the reference
FEW = 20  # of each of the others, and on a busy machine
BUSY = 4  # processes
GROUP = 20  # runs with the same builds; the first makes them
SHOWN = 5  # differences that are told
# Ten that fail, each in a way of its own; three are not known mistakes.
FAILING = (
    "rect_not_clipped",  # writes outside the picture
    "trace_no_depth_limit",  # rays without end
    "sphere_miss_writes",  # an output that must stay as it was
    "shadow_acne",  # a picture of noise
    "samples_outside_pixel",  # an edge
    "glass_odds_reversed",  # drawn by lot
    "octree_stops_at_leaf",  # what is counted
)
LOOP = {"float ratio = (n1 - n2) / (n1 + n2);": "float ratio = 0.f;\n    while (n1 > 0.f) {\n    }"}


@dataclass(frozen=True)
class Series:
    """A program that is graded several times, on a machine that is busy or not."""

    program: Program
    count: int
    busy: bool = False

    @property
    def name(self) -> str:
        """The program, and the machine."""
        return f"{self.program.id}, on a busy machine" if self.busy else self.program.id


def all_series() -> list[Series]:
    """Return what is graded, and how often."""
    reference = Program("reference", patches.reference())
    failing = _failing()
    again = [Series(reference, FEW, busy=True), Series(failing[0], FEW, busy=True)]
    return [*again, *(Series(each, FEW) for each in failing), Series(reference, RUNS)]


def _failing() -> list[Program]:
    files = patches.reference()
    ((before, after),) = LOOP.items()
    looping = {**files, "raytracer.c": files["raytracer.c"].replace(before, after)}
    by_id = {each.id: each for each in mistakes.load()}
    return [
        Program("endless loop", looping),
        Program("constants", solver.files(1)),
        nothing.skeleton(),
        *(known.program(by_id[name]) for name in FAILING),
    ]


def run(grade_cache: GradeCache, sample: int | None = None) -> Part:
    """Grade each series, or each at most that often. Raises ProofError."""
    found = []
    for series in all_series():
        count = series.count if sample is None else min(sample, series.count)
        found.append((series, repeated(grade_cache, series, count)))
    return report(found, sample is None)


def report(found: Sequence[tuple[Series, RepeatedRuns]], whole: bool = True) -> Part:
    """Return the part of the proof from what the runs of each series gave."""
    return Part(
        "flakiness",
        "The same results again and again",
        {
            "runs": sum(each.runs for _, each in found),
            "flaky": sum(each.others for _, each in found),
        },
        [
            f"{series.name}: {record.others} of {record.runs} runs differ: {line}"
            for series, record in found
            for line in record.differences[:SHOWN]
        ],
        ["submission", "runs", "that differ"],
        [[series.name, str(each.runs), str(each.others)] for series, each in found],
        whole,
    )


@dataclass(frozen=True)
class RepeatedRuns:
    """What the runs of a series gave."""

    runs: int
    others: int  # that did not give what most of them gave
    differences: list[str]


def repeated(grade_cache: GradeCache, series: Series, count: int) -> RepeatedRuns:
    """Grade a program until it has been graded that often; return what all the runs gave."""
    folder = grade_cache.folder / "runs" / f"{series.program.key}{'-busy' if series.busy else ''}"
    log = folder / "log.json"
    seen: dict[str, int] = json.loads(log.read_text(encoding="utf-8")) if log.is_file() else {}
    for content in _runs(grade_cache, series, count - sum(seen.values())):
        text = json.dumps(content, sort_keys=True)
        digest = content_key(text)
        if digest not in seen:
            write(folder / f"{digest}.json", content)
        seen[digest] = seen.get(digest, 0) + 1
        write(log, seen)
    usual, *others = sorted(seen, key=lambda each: -seen[each])
    return RepeatedRuns(
        runs=sum(seen.values()),
        others=sum(seen[each] for each in others),
        differences=[line for each in others for line in _compared(folder, usual, each)],
    )


def _runs(grade_cache: GradeCache, series: Series, count: int) -> Iterator[dict[str, Any]]:
    """Yield the results of each run; every group of them begins with nothing built."""
    grade_cache.folder.mkdir(parents=True, exist_ok=True)
    with load.busy(BUSY) if series.busy else contextlib.nullcontext():
        for start in range(0, count, GROUP):
            with tempfile.TemporaryDirectory(dir=grade_cache.folder) as folder:
                Path(folder).chmod(0o755)
                builds = Path(folder) / "cache"
                group = [series.program] * min(GROUP, count - start)
                yield from (content for _, content in grade_cache.each(group, builds))


def _compared(folder: Path, one: str, other: str) -> list[str]:
    """Return where two contents differ, a line each."""
    first, second = (
        json.loads((folder / f"{each}.json").read_text(encoding="utf-8")) for each in (one, other)
    )
    return differences(first, second)


def differences(one: object, other: object, place: str = "") -> list[str]:
    """Return where two JSON values differ, a line each."""
    if isinstance(one, dict) and isinstance(other, dict):
        keys = [*one, *(key for key in other if key not in one)]
        pairs = [(f"{place}.{key}", one.get(key), other.get(key)) for key in keys]
    elif isinstance(one, list) and isinstance(other, list):
        both = zip_longest(one, other)
        pairs = [(f"{place}[{k}]", *pair) for k, pair in enumerate(both)]
    else:
        return [] if one == other else [f"{place}: {one!r:.80} or {other!r:.80}"]
    return [line for where, a, b in pairs for line in differences(a, b, where)]
