"""Right solutions get every point on inputs that nobody has seen, as a class is graded."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from grader.authoring.expected import command
from grader.authoring.proof.grades import Grade, GradeCache, Program, ProofError
from grader.authoring.proof.parts import Part, sampled
from grader.authoring.proof.right import COMPILERS, faults
from grader.authoring.specimens import variants
from grader.authoring.specimens.variants import Variant

SEEDS = (11, 12, 13, 14)  # each program is graded on the inputs of one of them


def run(grade_cache: GradeCache, sample: int | None = None) -> Part:
    """Grade the variants, or some of them, on fresh inputs. Raises ProofError."""
    chosen = sampled(variants.load(), sample)
    folders = [_inputs(grade_cache.folder / "inputs" / str(seed), seed) for seed in SEEDS]
    programs = {
        each.id: Program(
            f"{each.id}, fresh",
            each.files(),
            each.flags,
            each.compiler or COMPILERS[0],
            inputs=folders[number % len(folders)],
        )
        for number, each in enumerate(chosen)
    }
    grades = {each.id: grade for each, grade in grade_cache.graded(programs.values())}
    found = [(each, programs[each.id].inputs.name, grades[programs[each.id].id]) for each in chosen]
    return report(found, sample is None)


def report(found: Sequence[tuple[Variant, str, Grade]], whole: bool = True) -> Part:
    """Return the part of the proof from grades of variants, each with the seed of its inputs."""
    lines = [faults(variant, variant.id, grade) for variant, _, grade in found]
    return Part(
        "fresh",
        "Right solutions on inputs that nobody has seen",
        {"fresh": len(found), "fresh_full": sum(not each for each in lines)},
        [line for each in lines for line in each],
        ["variant", "seed", "points"],
        [[variant.id, seed, f"{grade.score:.2f}"] for variant, seed, grade in found],
        whole,
    )


def _inputs(folder: Path, seed: int) -> Path:
    """Make the inputs of a seed, without what names mistakes. Raises ProofError."""
    words = ["--seed", str(seed), "--out", str(folder), "--without-bank"]
    if command.main(words):
        raise ProofError(f"{folder}: the inputs of seed {seed} could not be made")
    return folder
