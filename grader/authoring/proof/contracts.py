"""Every sentence of the contracts is checked: what breaks it, and nothing else, loses points."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from grader.authoring.proof.edits import caught
from grader.authoring.proof.grades import GradeCache
from grader.authoring.proof.parts import Part, sampled
from grader.authoring.specimens import contracts, mistakes
from grader.authoring.specimens.contracts import Contracts


def run(grade_cache: GradeCache, sample: int | None = None) -> Part:
    """Judge the breaches, or some of them."""
    table = contracts.load()
    chosen = sampled(table.breaches, sample)
    found = dict(caught(chosen, grade_cache.folder / "contracts"))
    return report(table, {each.id: found[each.id] for each in chosen}, sample is None)


def report(table: Contracts, found: Mapping[str, str], whole: bool = True) -> Part:
    """Return the part of the proof from the checks that catch breaches, by their ids."""
    known = {each.id: each for each in mistakes.load()}
    programs = {name: check for name, check in found.items() if check}
    programs |= {name: each.shows[0] for name, each in known.items()}
    rows = [
        [each.exercise, each.text, name, programs.get(name, "")]
        for each in table.sentences
        for name in (*each.broken_by, *each.allows)
        if name in programs or name in found or name in each.allows
    ]
    return Part(
        "contracts",
        "Every sentence of the contracts",
        {
            "sentences": len(table.sentences),
            "sentences_broken": sum(bool(each.broken_by) for each in table.sentences),
            "breaches": len(found),
            "breaches_caught": sum(map(bool, found.values())),
        },
        [*faults(table), *(f"{name}: not caught" for name, check in found.items() if not check)],
        ["exercise", "sentence", "program", "caught by"],
        rows,
        whole,
    )


def faults(table: Contracts) -> list[str]:
    """Return what the table lacks, or has too much of, a line each."""
    written = contracts.sentences(contracts.HEADER.read_text(encoding="utf-8"))
    told = {(each.exercise, each.text) for each in table.sentences}
    lines = [f"{exercise}: no program breaks: {text}" for exercise, text in _less(written, told)]
    lines += [
        f"{exercise}: exercises.h does not say: {text}" for exercise, text in told - {*written}
    ]
    used = {name for each in table.sentences for name in each.broken_by}
    lines += [f"{each.id}: breaks no sentence" for each in table.breaches if each.id not in used]
    named = {each.id for each in table.breaches} | {each.id for each in mistakes.load()}
    return lines + [f"{name}: no such program" for name in sorted(used - named)]


def _less(rows: Iterable[tuple[str, str]], others: set[tuple[str, str]]) -> list[tuple[str, str]]:
    return [each for each in rows if each not in others]
