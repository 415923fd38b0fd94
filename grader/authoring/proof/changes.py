"""The mutants as a part of the proof: what mutants.py counts."""

from __future__ import annotations

from grader.authoring.proof import mutants
from grader.authoring.proof.grades import GradeCache
from grader.authoring.proof.mutants import MutantsReport, Verdict
from grader.authoring.proof.parts import Part

LEAST, LEAST_OF_FUNCTION = 0.98, 0.95
MOST_BY_REASON = 0.02  # of the equivalent ones: those that are so by a sentence, not by proof


def run(grade_cache: GradeCache, sample: int | None = None) -> Part:
    """Judge the mutants, or some of them."""
    return report(mutants.run(grade_cache.jobs, sample), sample is None)


def report(found: MutantsReport, whole: bool = True) -> Part:
    """Return the part of the proof from what became of the mutants."""
    scores = sorted(found.functions, key=lambda each: each.score)
    return Part(
        "mutants",
        "Small changes of the solution",
        {
            "mutants": found.total,
            "equivalent": found.equivalent,
            "mutation_score": found.score,
            "mutation_score_worst_function": found.worst.score,
        },
        [*_faults(found), *(f"not caught: {_told(each)}" for each in found.survivors)],
        ["function", "mutants", "change nothing", "caught", "score"],
        [
            [e.function, str(e.total), str(e.equivalent), str(e.caught), f"{e.score:.1%}"]
            for e in scores
        ],
        whole,
    )


def _faults(found: MutantsReport) -> list[str]:
    faults = []
    if found.score < LEAST:
        faults.append(f"{found.score:.1%} caught, below {LEAST:.0%}")
    if found.worst.score < LEAST_OF_FUNCTION:
        faults.append(f"{found.worst.function}: {found.worst.score:.1%} caught")
    reasoned = [each for each in found.equivalents if each.reason]
    if len(reasoned) > MOST_BY_REASON * found.total:
        faults.append(f"{len(reasoned)} mutants are called equivalent without a proof")
    return faults


def _told(mutant: Verdict) -> str:
    before, after = (" ".join(text.split()) for text in (mutant.before, mutant.after))
    return f"{mutant.file}:{mutant.line} {mutant.function}: {before} → {after or '(nothing)'}"
