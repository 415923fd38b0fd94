"""The reference with one exercise put back to its stub, as a student has it who left it out."""

from __future__ import annotations

from pathlib import Path

from grader.authoring.skeleton.skeleton import MarkedRegion, find_regions, stub_lines
from grader.course.exercises import Manifest

REFERENCE = Path(__file__).resolve().parents[3] / "reference"


def without(exercise: str, rules: Manifest) -> dict[str, str]:
    """Return the reference's files, by name, with that exercise's stub in its place.

    What another exercise adds to the same function goes too when it depends on this one. Helper
    functions stay: others call them.
    """
    return {name: _without(REFERENCE / name, exercise, rules) for name in rules.student}


def _without(path: Path, exercise: str, rules: Manifest) -> str:
    lines = path.read_text(encoding="utf-8").split("\n")
    regions = find_regions(path, lines, {each.id for each in rules.exercises})
    dropped = [each for each in regions if _is_dropped(each, exercise, regions, lines, rules)]
    noted: set[str] = set()
    out: list[str] = []
    position = 0
    for region in dropped:
        if "}" in lines[position : region.begin]:
            noted.clear()
        out += [*lines[position : region.begin], *stub_lines(region, noted)]
        position = region.end + 1
    return "\n".join([*out, *lines[position:]])


def _is_dropped(
    region: MarkedRegion,
    exercise: str,
    regions: list[MarkedRegion],
    lines: list[str],
    rules: Manifest,
) -> bool:
    if not region.indent:
        return False
    if region.exercise == exercise:
        return True
    here = {
        each.exercise
        for each in regions
        if "}" not in lines[min(each.end, region.end) : max(each.begin, region.begin)]
    }
    return exercise in here and exercise in rules.exercise(region.exercise).depends
