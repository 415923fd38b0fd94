"""Right solutions written differently get every point, whoever builds them."""

from __future__ import annotations

from collections.abc import Iterable

from grader.authoring.proof.grades import Grade, GradeCache, Program
from grader.authoring.proof.parts import Part, sampled
from grader.authoring.specimens import variants
from grader.authoring.specimens.variants import Variant

COMPILERS = ("gcc", "clang")


def run(grade_cache: GradeCache, sample: int | None = None) -> Part:
    """Grade the variants, or some of them, built by each compiler. Raises ProofError."""
    builds = {
        each.id: (variant, each)
        for variant in sampled(variants.load(), sample)
        for each in programs(variant)
    }
    grades = {
        each.id: grade for each, grade in grade_cache.graded(each for _, each in builds.values())
    }
    found = [(variant, each.id, grades[each.id]) for variant, each in builds.values()]
    return report(found, sample is None)


def programs(variant: Variant) -> list[Program]:
    """Return a variant as it says to be built, and by the other compiler where it does not say."""
    files = variant.files()
    if variant.compiler:
        return [Program(variant.id, files, variant.flags, variant.compiler)]
    return [Program(f"{variant.id}, {each}", files, variant.flags, each) for each in COMPILERS]


def report(found: Iterable[tuple[Variant, str, Grade]], whole: bool = True) -> Part:
    """Return the part of the proof from the grades of variants, each with the build's name."""
    found = list(found)
    lines = {name: faults(variant, name, grade) for variant, name, grade in found}
    names = {variant.id for variant, _, _ in found}
    broken = {variant.id for variant, name, _ in found if lines[name]}
    return Part(
        "variants",
        "Right solutions written differently",
        {
            "variants": len(names),
            "variants_full": len(names - broken),
            "variant_builds": len(found),
            "variant_builds_full": sum(not each for each in lines.values()),
        },
        [line for each in lines.values() for line in each],
        ["variant", "what is different", "points"],
        [[name, variant.about, f"{grade.score:.2f}"] for variant, name, grade in found],
        whole,
    )


def faults(variant: Variant, name: str, grade: Grade) -> list[str]:
    """Return the checks that lost points, a line each.

    Of a variant apart, functions that it never calls are to do, and their pictures with them.
    """
    return [
        f"{name}: {each['id']} ({each['outcome']}): {each['message']}"
        for each in grade.content["checks"]
        if each["points"] < each["max_points"] and not (variant.apart and each["outcome"] == "todo")
    ]
