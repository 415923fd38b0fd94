"""Programs from outside lose what a teacher takes off, where it is wrong, and are not misnamed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from grader.authoring.proof.grades import Grade, GradeCache, Program
from grader.authoring.proof.parts import Part, listed, sampled
from grader.authoring.specimens import cases, shares
from grader.authoring.specimens.cases import Case
from grader.authoring.specimens.shares import Range


def run(grade_cache: GradeCache, sample: int | None = None) -> Part:
    """Grade the programs, or some of them. Raises ProofError."""
    chosen = sampled(cases.load(), sample)
    programs = (Program(each.id, each.files()) for each in chosen)
    grades = {each.id: grade for each, grade in grade_cache.graded(programs)}
    return report([(each, grades[each.id]) for each in chosen], sample is None)


def report(found: Sequence[tuple[Case, Grade]], whole: bool = True) -> Part:
    """Return the part of the proof from the grades of programs."""
    lines = [faults(each, grade) for each, grade in found]
    return Part(
        "cases",
        "Programs from outside",
        {"cases": len(lines), "cases_fair": sum(not each for each in lines)},
        [line for each in lines for line in each],
        ["program", "what is wrong", "loses", "deserves to lose"],
        [
            [
                each.id,
                each.about,
                _told({name: f"{share:.0%}" for name, share in grade.shares.items()}),
                _told({name: shares.told(share) for name, share in each.loses.items()}),
            ]
            for each, grade in found
        ],
        whole,
    )


def faults(case: Case, grade: Grade) -> list[str]:
    """Return what is not as it should be, a line each."""
    if case.earns is not None:
        earned = f"{case.id}: earns {grade.score:g}, at most {case.earns:g} for no work"
        return [earned] if grade.score > case.earns else []
    lines = unfair(case.id, grade.shares, case.loses)
    told = {name for names in grade.named.values() for name in names}
    if wrong := told - {*case.named}:
        lines.append(f"{case.id}: named {listed(wrong)}")
    if case.named and not told:
        lines.append(f"{case.id}: not named {listed(case.named)}")
    return lines


def unfair(name: str, lost: Mapping[str, float], fair: Mapping[str, Range]) -> list[str]:
    """Return the exercises in which a program loses more or less than a teacher takes off."""
    lines = []
    for exercise in sorted(lost.keys() | fair.keys()):
        share, (least, most) = lost.get(exercise, 0.0), fair.get(exercise, (0.0, 0.0))
        if not least <= round(share, 3) <= most:
            span = shares.told((least, most))
            lines.append(f"{name}: loses {share:.0%} of {exercise}, where {span} is fair")
    return lines


def _told(shares: Mapping[str, object]) -> str:
    return ", ".join(f"{name} {each}" for name, each in sorted(shares.items())) or "nothing"
