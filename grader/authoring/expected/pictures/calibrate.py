"""make calibrate: the limits of pictures, from right programs; and how far mistakes exceed them.

Right programs are the variants of reference/variants/, the reference under other compilers and
flags, and mixtures of accepted choices drawn by lot. With a hundred other mixtures nothing is set:
they show that the limits hold for what they were not made from.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from grader.authoring.expected.pictures import calibration
from grader.authoring.expected.pictures.make import write_limits
from grader.authoring.expected.pictures.measuring import Reached, measured
from grader.authoring.expected.pictures.sources import (
    HELD_OUT,
    by_mistake,
    mixtures,
    right_programs,
)
from grader.authoring.expected.pictures.wrongs import TABLE
from grader.authoring.specimens import mistakes
from grader.checking.expected_data import FOLDER
from grader.checking.pictures import expected_files
from grader.checking.pictures.plan import judged
from grader.files import write_whole


def set_limits() -> int:
    """Set the limits, and write them beside the pictures; return the exit code."""
    table = worst(measured(right_programs(), judged()))
    write_whole(calibration.TABLE, json.dumps(table, indent=1) + "\n")
    calibration.forget()
    write_limits(FOLDER / expected_files.FOLDER)
    too_near = []
    for picture in judged():
        for name, row in calibration.limits(picture).items():
            line = f"{picture.name:20} {name:6} worst {row['worst']:<9g} limit {row['limit']:<8g}"
            print(f"{line} margin {row['margin'] or 'any'}")
            if row["limit"] > calibration.HIGHEST * calibration.defaults(picture)[name]:
                too_near.append(f"{line} {row['reason']}")
    for line in too_near:
        print(f"a right program comes within {calibration.MARGIN:g}x of the highest limit: {line}")
    return 1 if too_near else 0


def worst(reached: Sequence[Reached]) -> dict[str, dict[str, Any]]:
    """Return the worst of each measure by picture, as calibration.json holds it."""
    table: dict[str, dict[str, Any]] = {}
    for each in reached:
        row = table.setdefault(each.picture.name, {})
        for name in calibration.defaults(each.picture):
            value = round(float(getattr(each.measures, name)), 6)
            if value > row.get(name, {"worst": 0.0})["worst"]:
                row[name] = {"worst": value, "variant": each.source}
    return dict(sorted(table.items()))


def try_mixtures() -> int:
    """Judge programs with which nothing was set; return the exit code."""
    held_out = mixtures(*HELD_OUT)
    reached = measured(held_out, judged())
    failed = {each.source for each in reached if each.exceeds > 1}
    count = len(held_out)
    right = f"{count - len(failed)}/{count}"
    print(f"mixtures with all of their {len(judged())} pictures right: {right}")
    near = [each for each in reached if each.exceeds > 1 / calibration.MARGIN]
    for each in sorted(near, key=lambda each: -each.exceeds):
        print(f"  too near: {each.source}, {each.picture.name}: {each.exceeds:.2f} of the limit")
    return 1 if near else 0


def try_wrongs() -> int:
    """Judge pictures that are wrong in known ways; return the exit code."""
    print("what is said of wrong pictures:")
    bad = 0
    for each in TABLE:
        complaint = each.complaint(each.judged())
        bad += bool(complaint)
        print(f"  {each.id:28} {each.picture.name:20} {complaint or each.key}")
    print(f"told as they must be: {len(TABLE) - bad} of {len(TABLE)}")
    return 1 if bad else 0


def try_mistakes() -> None:
    """Say how far the known mistakes exceed the limits."""
    shown = []
    for mistake in mistakes.load():
        if mistake.tp > 1 and (reached := measured([by_mistake(mistake)], judged())):
            shown.append(max(reached, key=lambda each: each.exceeds))
    print("known mistakes, by the picture that shows them most, in multiples of the limit:")
    for each in sorted(shown, key=lambda each: each.exceeds):
        print(f"  {each.source:32} {each.picture.name:20} {each.exceeds:8.1f}")
    print(f"that show: {sum(each.exceeds > 1 for each in shown)} of {len(shown)}")
