"""What `make bench` prints and writes: tables, goals, results.json."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from grader.authoring.bench.grading import Grading
from grader.authoring.bench.measure import Measured
from grader.files import write_whole

# Render seconds of an earlier run of the same workload on one machine. c-ray-fast 2.0 is in no
# distribution: its figures are brought to this machine by the ratio of POV-Ray's.
PUBLISHED_POVRAY = {"small": 0.84, "flake4": 2.09, "flake5": 3.72, "flake6": 4.76}
PUBLISHED_CRAY = {"flake4": 3.08, "flake5": 7.68, "flake6": 18.8}

# On two quiet cores, the environment and the given files' objects at hand.
GRADING_SECONDS = {"whole": 3.0, "units": 2.0, "one": 1.0}
GRADING_RATIO = 1.5  # CPU of the whole, over what compiling and the submission itself take
GRADING_MB = 500.0
CANARY_SECONDS = 0.1


@dataclass(frozen=True)
class Goal:
    """A number that should not exceed a limit."""

    what: str
    value: float
    limit: float

    @property
    def met(self) -> bool:
        """Whether it does not; NaN never does."""
        return self.value <= self.limit


def goals(
    measured: Sequence[Measured], octree_ratios: Mapping[str, float], grading: Grading
) -> list[Goal]:
    """Return every goal of the benchmarks, with what was measured."""
    found = [goal for scene in measured for goal in _scene_goals(scene)]
    found += [
        Goal(f"scene {name}: time with octree / without", ratio, 1.1)
        for name, ratio in octree_ratios.items()
    ]
    return [*found, *_grading_goals(grading)]


def _grading_goals(grading: Grading) -> Iterator[Goal]:
    for name, each in grading.grades.items():
        yield Goal(f"grading, {name}: seconds of wall time", each.wall, GRADING_SECONDS[name])
    whole, limit = grading.grades["whole"].cpu, grading.limit
    what = f"grading, whole: CPU ({whole:.2f} s) / limit ({limit:.2f} s)"
    yield Goal(what, whole / limit, GRADING_RATIO)
    yield Goal("grading: peak memory, MB", grading.peak_mb, GRADING_MB)
    yield Goal("canary: seconds of wall time", grading.canary, CANARY_SECONDS)


def _scene_goals(scene: Measured) -> Iterator[Goal]:
    name, counts = scene.name, scene.counts
    yield Goal(f"{name}: pictures with and without octree differ", float(not scene.same_picture), 0)
    if "povray" in scene.costs:
        yield Goal(f"{name}: render / POV-Ray's", scene.ratio("povray", "render"), 1)
        yield Goal(f"{name}: build / POV-Ray's parsing", scene.ratio("povray", "build"), 1)
        off = abs(counts.rays / scene.costs["povray"][0].rays - 1)
        yield Goal(f"{name}: rays off POV-Ray's, %", 100 * off, 0.2)
    if "tachyon" in scene.costs:
        yield Goal(f"{name}: render / Tachyon's (stretch)", scene.ratio("tachyon", "render"), 1)
    if name in PUBLISHED_CRAY:
        if "povray" in scene.costs:
            ratio = scene.median("mrt", "render") / scaled_cray(scene)
            yield Goal(f"{name}: render / c-ray-fast's, scaled", ratio, 0.5)
        yield Goal(f"{name}: octree bytes a sphere", counts.bytes_per_object, 150)
    if name == "flake5":
        yield Goal(f"{name}: tests a ray / without octree", counts.tests / scene.plain_tests, 1e-3)


def scaled_cray(scene: Measured) -> float:
    """Return c-ray-fast's published seconds, scaled to this machine by POV-Ray's."""
    factor = scene.median("povray", "render") / PUBLISHED_POVRAY[scene.name]
    return PUBLISHED_CRAY[scene.name] * factor


def table(rows: Sequence[Sequence[str]]) -> str:
    """Lay out rows of text in columns, the first to the left, the others to the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = (
        "  ".join([row[0].ljust(widths[0]), *map(str.rjust, row[1:], widths[1:])]).rstrip()
        for row in rows
    )
    return "\n".join(lines)


def text(measured: Sequence[Measured], octree_ratios: Mapping[str, float], grading: Grading) -> str:
    """Return the whole report as a person reads it."""
    parts = [
        "One thread, 1280x720, CPU seconds, medians; the tree's building or the file's parsing "
        "in brackets",
        table(list(_time_rows(measured))),
        "Object tests a ray, and the octree's memory (the plain list on smaller pictures)",
        table(list(_count_rows(measured))),
        "Goals",
        table([goal_row(goal) for goal in goals(measured, octree_ratios, grading)]),
    ]
    absent = {"povray", "tachyon"} - set(measured[0].costs)
    if absent:
        parts.append(f"Not installed here, and left out: {', '.join(sorted(absent))}")
    return "\n\n".join(parts)


def _time_rows(measured: Iterable[Measured]) -> Iterator[list[str]]:
    yield ["scene", "spheres", "rays, M", "ours", "POV-Ray", "Tachyon", "c-ray-fast, scaled"]
    for scene in measured:
        row = [scene.name, f"{scene.counts.objects - 1:,}", f"{scene.counts.rays / 1e6:.2f}"]
        for program in ("mrt", "povray", "tachyon"):
            if program in scene.costs:
                render = scene.median(program, "render")
                row.append(f"{render:.2f} ({scene.median(program, 'build'):.3f})")
            else:
                row.append("-")
        known = scene.name in PUBLISHED_CRAY and "povray" in scene.costs
        yield [*row, f"{scaled_cray(scene):.2f}" if known else "-"]


def _count_rows(measured: Iterable[Measured]) -> Iterator[list[str]]:
    yield ["scene", "octree", "plain", "fewer", "us a ray, plain", "bytes a sphere", "building"]
    for scene in measured:
        counts = scene.counts
        yield [
            scene.name,
            f"{counts.tests:.2f}",
            f"{scene.plain_tests:,.0f}",
            f"{scene.plain_tests / counts.tests:,.0f} x",
            f"{scene.plain_seconds:,.2f}",
            f"{counts.bytes_per_object:.0f}",
            f"{counts.build_bytes / counts.objects:.0f}",
        ]


def goal_row(goal: Goal) -> list[str]:
    """Return the row of a goal in a table."""
    return [goal.what, f"{goal.value:.3g}", f"<= {goal.limit:g}", "yes" if goal.met else "MISSED"]


def write_json(
    path: Path,
    measured: Sequence[Measured],
    octree_ratios: Mapping[str, float],
    grading: Grading,
) -> None:
    """Write everything measured, whole or not at all."""
    content = {
        "schema": 1,
        "scenes": [
            {**asdict(each), "bytes_per_object": each.counts.bytes_per_object} for each in measured
        ],
        "octree_ratios": dict(octree_ratios),
        "grading": asdict(grading),
        "goals": [
            {**asdict(goal), "met": goal.met} for goal in goals(measured, octree_ratios, grading)
        ],
    }
    write_whole(path, json.dumps(content, indent=2) + "\n")
