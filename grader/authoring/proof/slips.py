"""Mistakes that students may well make lose points in their own exercise."""

from __future__ import annotations

from collections.abc import Iterable

from grader.authoring.proof.edits import caught
from grader.authoring.proof.grades import GradeCache
from grader.authoring.proof.parts import Part, sampled
from grader.authoring.specimens import slips
from grader.authoring.specimens.slips import Slip


def run(grade_cache: GradeCache, sample: int | None = None) -> Part:
    """Judge the slips, or some of them."""
    chosen = sampled(slips.load(), sample)
    found = dict(caught(chosen, grade_cache.folder / "slips"))
    return report([(each, found[each.id]) for each in chosen], sample is None)


def report(found: Iterable[tuple[Slip, str]], whole: bool = True) -> Part:
    """Return the part of the proof from slips, each with the check that catches it, or ""."""
    found = list(found)
    return Part(
        "slips",
        "Mistakes that students may well make",
        {"slips": len(found), "slips_caught": sum(bool(check) for _, check in found)},
        [f"{each.id}: not caught" for each, check in found if not check],
        ["exercise", "slip", "what led to it", "caught by"],
        [[each.exercise, each.id, each.thought, check] for each, check in found],
        whole,
    )
