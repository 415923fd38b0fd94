"""Half-written programs: the reference with some exercises put back to their stubs.

This is what a student has who left an exercise out, or who has just reached one: everything before
it is written, everything after it is a stub.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

from grader.authoring.skeleton.skeleton import MarkedRegion, find_regions, stub_lines
from grader.authoring.specimens import patches
from grader.course import exercises as manifest
from grader.course.exercises import Manifest


def just_reached(
    exercise: str, files: Mapping[str, str] | None = None, *, bonuses: bool = True
) -> dict[str, str]:
    """Return the files of who has just written an exercise: those after it are stubs.

    `files` are the reference's, or a change of them; without `bonuses` those before it are stubs
    too. What else an exercise is written in (TP5.2 in shade) goes when it comes later.
    """
    rules = manifest.load()
    ids = [each.id for each in rules.exercises]
    left = set(ids[ids.index(exercise) + 1 :])
    if not bonuses:
        left |= {each.id for each in rules.exercises if each.bonus} - {exercise}
    return without(left, files)


def without(exercises: Collection[str], files: Mapping[str, str] | None = None) -> dict[str, str]:
    """Return the files with the stubs of these exercises in their place.

    What another exercise adds to the same function goes too when it depends on one of these. Helper
    functions stay: others call them.
    """
    rules = manifest.load()
    files = patches.reference() if files is None else files
    return {name: _without(name, text, exercises, rules) for name, text in files.items()}


def _without(name: str, text: str, exercises: Collection[str], rules: Manifest) -> str:
    lines = text.split("\n")
    regions = find_regions(Path(name), lines, {each.id for each in rules.exercises})
    dropped = [each for each in regions if _is_dropped(each, exercises, regions, lines, rules)]
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
    exercises: Collection[str],
    regions: Sequence[MarkedRegion],
    lines: Sequence[str],
    rules: Manifest,
) -> bool:
    if not region.indent:
        return False
    if region.exercise in exercises:
        return True
    here = {
        each.exercise
        for each in regions
        if "}" not in lines[min(each.end, region.end) : max(each.begin, region.begin)]
    }
    return bool(here & {*exercises} & {*rules.exercise(region.exercise).depends})
