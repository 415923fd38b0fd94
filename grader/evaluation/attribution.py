"""Judging later stages fairly: what failed is judged again among the reference's functions.

A check that did not pass may have failed because of another exercise, on which its own depends.
Where the reference is present it is run again with the reference's versions of these in the place
of the submission's: when it passes then, the points are earned, and the finding says through what;
when it does not, the fault is its own.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from grader.build import substitution
from grader.checking.student import Student
from grader.course.exercises import Check, Manifest
from grader.evaluation.grading import at_fault, is_judged, unwritten
from grader.evaluation.records import Finding, Outcome
from grader.execution.libraries import NOT_LINKED, Libraries

Again = Callable[[str, Student], Finding]  # runs a check, by its id, on another build


def attribute(
    findings: Sequence[Finding], rules: Manifest, libraries: Libraries, folder: Path, again: Again
) -> list[Finding]:
    """Return the findings, those of the checks that were run again in place of the first ones.

    `folder` holds the expected data.
    """
    if not substitution.is_possible():
        return list(findings)
    found = {each.check: each for each in findings}
    # What needs fewer exercises first, and last what judges others' functions besides: whether
    # these are right is known when it is asked.
    order = sorted(
        (rules.checks()[name] for name in found),
        key=lambda check: (bool(check.judges), len(rules.needed(check)), check.exercise),
    )
    ahead = unwritten(findings, rules)
    lent: frozenset[str] = frozenset()
    looping: set[str] = set()  # exercises that do so among the reference's functions too
    with contextlib.ExitStack() as stack:
        for check in order:
            if check.exercise in ahead or not is_judged(found[check.id], check):
                continue
            if not (names := _replaced(check, found, rules)):
                continue
            looped = found[check.id].outcome is Outcome.TIMEOUT and check.exercise in looping
            if looped or _loops(found[check.id], rules):
                found[check.id] = replace(found[check.id], alone=True)
                continue
            if names != lent:
                stack.close()
                library_set, lent = stack.enter_context(libraries.mixed(names)), names
            own = rules.exercise(check.exercise).functions
            second = again(check.id, Student(library_set, folder, own))
            if second.outcome is Outcome.TIMEOUT:
                looping.add(check.exercise)
            found[check.id] = _settled(found, check, second, rules)
    return _blamed([found[each.check] for each in findings], rules)


def _blamed(findings: Sequence[Finding], rules: Manifest) -> list[Finding]:
    """Return the findings; those that passed among the reference's functions say through what.

    Only now is it known which of the exercises that they need are wrong in the end.
    """
    wrong = at_fault(findings, rules)

    def guilty(finding: Finding) -> tuple[str, ...]:
        needed = rules.needed(rules.checks()[finding.check])
        return tuple(sorted(needed & wrong or finding.through))

    return [replace(each, through=guilty(each)) if each.through else each for each in findings]


def _replaced(check: Check, found: Mapping[str, Finding], rules: Manifest) -> frozenset[str]:
    """Return the functions for which the reference's stand in when a check is run again.

    What the check judges beside its own exercise stays, unless that is wrong by itself.
    """
    wrong = at_fault(found.values(), rules)
    exercises = rules.needed(check) - (set(check.judges) - wrong)
    names = {name for each in exercises for name in rules.exercise(each).functions}
    return frozenset(names - judged(check, found, rules))


def judged(check: Check, found: Mapping[str, Finding], rules: Manifest) -> frozenset[str]:
    """Return the functions of its own exercise that a check judges, one of them at least.

    One that is wrong in another exercise need not be, once a check of its own has passed.
    """
    wrong = rules.needed(check) & at_fault(found.values(), rules)
    faulty = {name for each in wrong for name in rules.exercise(each).functions}
    own = frozenset(rules.exercise(check.exercise).functions)

    def is_proven(name: str) -> bool:
        proof = found.get(check.proven.get(name, ""))
        return proof is not None and proof.outcome is Outcome.PASSED

    kept = frozenset(name for name in own if name not in faulty or not is_proven(name))
    return kept or own


def _loops(finding: Finding, rules: Manifest) -> bool:
    """Say whether the loop is in the exercise's own function, or in what the code does when loaded.

    It would take as long again.
    """
    values = finding.message.values if finding.message else {}
    own = rules.exercise(rules.checks()[finding.check].exercise).functions
    in_own = values.get("function") in own or values.get("call") == ""
    return finding.outcome is Outcome.TIMEOUT and in_own


def _settled(
    found: Mapping[str, Finding], check: Check, second: Finding, rules: Manifest
) -> Finding:
    """Return what a check has found in the end."""
    first = found[check.id]
    guilty = rules.needed(check) & at_fault(found.values(), rules)
    if second.outcome is Outcome.PASSED:
        return replace(second, through=tuple(sorted(check.needs)), output="")
    own = judged(check, found, rules)
    shared = any(own & set(rules.exercise(each).functions) for each in guilty)
    if check.exercise in second.todo or second.outcome is Outcome.ERROR:
        return second  # the machine's fault never becomes a mark
    if shared or (second.message and second.message.key == NOT_LINKED):
        return first  # what is at fault could not be replaced
    # What of a picture is right may now be the reference's own, or been so by chance before.
    share = min(first.evidence.share, second.evidence.share)
    evidence = replace(second.evidence, share=share)
    return replace(second, alone=True, output=first.output, evidence=evidence)
