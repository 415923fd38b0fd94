"""Every known mistake loses points in its own exercise, in no other, and is named right."""

from __future__ import annotations

from collections.abc import Iterable

from grader.authoring.proof.grades import Grade, GradeCache, Program
from grader.authoring.proof.parts import Part, listed, sampled
from grader.authoring.specimens import mistakes
from grader.authoring.specimens.mistakes import Mistake

RIGHT, WRONG, NONE = "right", "wrong", "none"


def run(grade_cache: GradeCache, sample: int | None = None) -> Part:
    """Grade the mistakes, or some of them. Raises ProofError."""
    chosen = sampled(mistakes.load(), sample)
    grades = {
        each.id: grade for each, grade in grade_cache.graded(program(each) for each in chosen)
    }
    return report([(each, grades[each.id]) for each in chosen], sample is None)


def program(mistake: Mistake) -> Program:
    """Return the reference with a mistake in it."""
    return Program(mistake.id, mistake.files())


def report(found: Iterable[tuple[Mistake, Grade]], whole: bool = True) -> Part:
    """Return the part of the proof from the grades of mistakes."""
    found = list(found)
    names = [naming(mistake, grade) for mistake, grade in found]
    figures = {
        "known_mistakes": len(found),
        "caught": sum(mistake.exercise in grade.losing for mistake, grade in found),
        "elsewhere": sum(bool(grade.losing - {mistake.exercise}) for mistake, grade in found),
        **{f"named_{each}": names.count(each) for each in (RIGHT, WRONG, NONE)},
    }
    return Part(
        "known",
        "Known mistakes",
        dict(figures),
        [fault for mistake, grade in found for fault in faults(mistake, grade)],
        ["mistake", "exercise", "points lost", "named"],
        [
            [mistake.id, mistake.exercise, f"{grade.missing:.2f}", name]
            for (mistake, grade), name in zip(found, names, strict=True)
        ],
        whole,
    )


def naming(mistake: Mistake, grade: Grade) -> str:
    """Say whether it is named right (alone, or with its twins), wrong, or not at all."""
    told = grade.named.values()
    accepted = {mistake.id, *mistake.twins}
    if not told:
        return NONE
    right = all(mistake.id in names and set(names) <= accepted for names in told)
    return RIGHT if right else WRONG


def faults(mistake: Mistake, grade: Grade) -> list[str]:
    """Return what is not as it should be, a line each."""
    found = []
    if mistake.exercise not in grade.losing:
        found.append(f"{mistake.id}: loses nothing in {mistake.exercise}")
    if others := grade.losing - {mistake.exercise}:
        found.append(f"{mistake.id} ({mistake.exercise}): loses in {listed(others)} too")
    if naming(mistake, grade) == WRONG:
        told = {name for names in grade.named.values() for name in names}
        found.append(f"{mistake.id}: named {listed(told)}")
    return found
