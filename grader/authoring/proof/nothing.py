"""What is no work earns no points: the skeleton, constants, and copies of what is given."""

from __future__ import annotations

from collections.abc import Mapping

from grader.authoring.proof import solver
from grader.authoring.proof.grades import Grade, GradeCache, Program
from grader.authoring.proof.parts import Part
from grader.course import exercises
from grader.course.exercises import CORE

SKELETON = "skeleton"


def run(grade_cache: GradeCache, sample: int | None = None) -> Part:
    """Grade the skeleton, and a solver's attempts or some of them. Raises ProofError."""
    turns = solver.TURNS if sample is None else min(sample, solver.TURNS)
    programs = [skeleton(), *(Program(f"attempt {k + 1}", solver.files(k)) for k in range(turns))]
    grades = {each.id: grade for each, grade in grade_cache.graded(programs)}
    return report({each.id: grades[each.id] for each in programs}, sample is None)


def skeleton() -> Program:
    """Return what students start from."""
    names = exercises.load().student
    return Program(SKELETON, {name: (CORE / name).read_text(encoding="utf-8") for name in names})


def report(grades: Mapping[str, Grade], whole: bool = True) -> Part:
    """Return the part of the proof from the grades of what is no work, by name."""
    earned = {
        name: [each["id"] for each in grade.content["checks"] if each["points"]]
        for name, grade in grades.items()
    }
    outcomes = {each["outcome"] for each in grades[SKELETON].content["checks"]}
    faults = [f"{name}: earns {check}" for name, checks in earned.items() for check in checks]
    # What does not compile earns nothing anyway.
    built = {name: grade.content["build"]["ok"] for name, grade in grades.items()}
    faults += [f"{name}: does not compile" for name, ok in built.items() if not ok]
    faults += [f"{SKELETON}: a check is {each}" for each in sorted(outcomes - {"todo"})]
    return Part(
        "nothing",
        "What is no work earns nothing",
        {"thoughtless": len(grades), "thoughtless_earning": sum(map(bool, earned.values()))},
        faults,
        ["submission", "points"],
        [[name, f"{grade.score:.2f}"] for name, grade in grades.items()],
        whole,
    )
