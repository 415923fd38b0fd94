"""Recognising known mistakes: a submission's wrong answers beside those that each mistake gives.

The bank, `mistakes.npz` of a folder of expected data, holds the observations of the known mistakes
in the checks of their exercises (authoring/expected/mistake_bank.py makes it). A mistake is
recognised when all that is wrong in an exercise is what the mistake gives, and nothing else is;
mistakes that the checks do not tell apart are named together, three at most. In pictures it is
recognised by what it draws, when it gives all the wrong pictures of an exercise and shows in no
check that is right. Nothing is guessed.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from grader.checking.expected_data import ExpectedError, arrays_of, read_manifest
from grader.checking.npz import archived
from grader.checking.observations import Array, Observation
from grader.checking.pictures.candidates import shown_in
from grader.course.exercises import Manifest
from grader.evaluation.records import Finding, Outcome
from grader.evaluation.rules import is_learnt, settle

BANK = "mistakes.npz"
MOST = 3  # mistakes named together
_WRONG = (Outcome.FAILED, Outcome.CRASHED, Outcome.TIMEOUT)

Parts = Mapping[str, Observation]
Signature = Mapping[str, Parts]  # by check, of those that found something wrong


@dataclass(frozen=True)
class KnownMistake:
    """A known mistake: its exercise, and what its checks find."""

    exercise: str
    signature: Signature


def with_mistakes(findings: Sequence[Finding], rules: Manifest, folder: Path) -> list[Finding]:
    """Return the findings with the ids of the mistakes that are recognised in them.

    `folder` is that of the expected data; one without a bank recognises nothing. Raises
    ExpectedError when the bank cannot be read.
    """
    settled = settle(findings, rules).findings
    wrong = {_exercise(each, rules) for each in settled if each.outcome in _WRONG}
    bank = read(folder) if wrong else {}
    found = {}
    for exercise in wrong if bank else ():
        own = [
            each
            for each in settled
            if _exercise(each, rules) == exercise and not rules.checks()[each.check].is_picture
        ]
        if any(map(is_learnt, own)):  # the bank has the answers to the inputs of the archive
            continue
        if all(each.outcome not in _WRONG for each in own):  # its pictures alone are wrong
            continue
        alone = all(each.alone for each in own if each.outcome in _WRONG)
        # What a wrong function hands on says nothing about those that use it.
        if alone or not wrong & _needed(exercise, rules):
            found[exercise] = recognised(own, bank)
    seen = _in_pictures(settled, rules, bank, found, folder)

    def ids(finding: Finding) -> tuple[str, ...]:
        exercise = _exercise(finding, rules)
        drawn = seen.get(exercise, ()) if rules.checks()[finding.check].is_picture else ()
        return found.get(exercise, ()) or drawn

    return [_with(each, ids(each)) for each in findings]


def _in_pictures(
    findings: Sequence[Finding],
    rules: Manifest,
    bank: Mapping[str, KnownMistake],
    found: Mapping[str, tuple[str, ...]],
    folder: Path,
) -> dict[str, tuple[str, ...]]:
    """Return, by exercise, the mistakes that give all of its wrong pictures, and nothing right.

    They may be another exercise's. `found` are those that other checks have named, by exercise,
    where these are wrong: what they do not name is not what is drawn.
    """
    common: dict[str, set[str]] = {}
    for each in findings:
        if rules.checks()[each.check].is_picture and each.outcome in _WRONG:
            exercise, known = _exercise(each, rules), set(each.candidates)
            common[exercise] = common.get(exercise, known) & known
    if not any(common.values()):
        return {}
    right = {each.check: each for each in findings if _is_right(each)}
    for name, mistake in bank.items():
        if mistake.signature.keys() & right.keys() or name not in found.get(
            mistake.exercise, (name,)
        ):
            common = {exercise: ids - {name} for exercise, ids in common.items()}
    for each in right.values():
        for picture in each.pictures:
            shown = set(shown_in(folder, picture))
            common = {exercise: ids - shown for exercise, ids in common.items()}
    return {name: tuple(sorted(ids)) for name, ids in common.items() if len(ids) <= MOST}


def _is_right(finding: Finding) -> bool:
    """Whether a check passed with the submission's own functions, as it is asked for."""
    return finding.outcome is Outcome.PASSED and not finding.through and not finding.remarks


def recognised(findings: Sequence[Finding], bank: Mapping[str, KnownMistake]) -> tuple[str, ...]:
    """Return the ids of the mistakes that explain all the findings of one exercise."""
    checks, seen = {each.check for each in findings}, signature(findings)
    unclear = any(each.outcome not in (*_WRONG, Outcome.PASSED) for each in findings)
    if unclear or not seen:
        return ()
    ids = [
        name
        for name, known in bank.items()
        if same(seen, {key: known.signature[key] for key in known.signature if key in checks})
    ]
    return tuple(ids) if len(ids) <= MOST else ()


def signature(findings: Sequence[Finding]) -> dict[str, dict[str, Observation]]:
    """Return what was found wrong, by check: the parts of the answers, and how it was told."""
    return {
        each.check: {**each.observations, _ending(each): _NOTHING}
        for each in findings
        if each.outcome in _WRONG
    }


_NOTHING = Observation(np.zeros(0, np.int64), np.zeros((0, 1), np.float32))


def _ending(finding: Finding) -> str:
    """Return how a check ended; of a call that did not come back, which one it was."""
    message = finding.message
    if message is None:
        return finding.outcome.value
    if finding.outcome is Outcome.FAILED:
        return message.key
    digest = hashlib.sha256(str(message.values.get("call", "")).encode()).hexdigest()
    # Which kind of forbidden access it was depends on what happens to lie beside the memory.
    return f"{finding.outcome.value} {digest[:8]}"


def same(seen: Signature, known: Signature) -> bool:
    """Say whether the same checks find the same answers wrong, by the first one's tolerances."""
    return seen.keys() == known.keys() and all(
        parts.keys() == known[check].keys()
        and all(part.agrees(known[check][name]) for name, part in parts.items())
        for check, parts in seen.items()
    )


def _exercise(finding: Finding, rules: Manifest) -> str:
    return rules.checks()[finding.check].exercise


def _needed(exercise: str, rules: Manifest) -> set[str]:
    """Return the exercises that one depends on, and those that these depend on."""
    direct = set(rules.exercise(exercise).depends)
    return direct.union(*(_needed(each, rules) for each in direct))


def _with(finding: Finding, ids: tuple[str, ...]) -> Finding:
    if finding.outcome not in _WRONG or not ids:
        return finding
    return replace(finding, evidence=replace(finding.evidence, mistakes=ids))


# ---- The bank -----------------------------------------------------------------------------------


def encode(bank: Mapping[str, KnownMistake]) -> bytes:
    """Return the content of the bank's file: the same bytes for the same mistakes."""
    cases: list[Array] = []
    values: list[Array] = []

    def place(part: Observation) -> list[int]:
        cases.append(part.cases)
        values.append(part.values)
        return list(part.values.shape)

    index = {
        name: {
            "exercise": known.exercise,
            "checks": {
                check: {key: place(part) for key, part in parts.items()}
                for check, parts in known.signature.items()
            },
        }
        for name, known in bank.items()
    }
    text = json.dumps(index, separators=(",", ":")).encode()
    return archived(
        {
            "index": np.frombuffer(text, np.uint8),
            "cases": np.concatenate([_EMPTY, *cases]).astype(np.uint16),
            "values": np.concatenate([_EMPTY, *(each.ravel() for each in values)]),
        }
    )


_EMPTY = np.zeros(0, np.float32)


def read(folder: Path) -> dict[str, KnownMistake]:
    """Read the bank of a folder; {} where there is none. Raises ExpectedError."""
    path = folder / BANK
    rules = read_manifest(folder).get("bank")
    return dict(_read(path, str(rules["sha256"]))) if rules else {}


@cache
def _read(path: Path, digest: str) -> Mapping[str, KnownMistake]:
    try:
        arrays = arrays_of(path, {"sha256": digest})
        index = json.loads(arrays["index"].tobytes())
        return _unpacked(index, arrays["cases"].astype(np.int64), arrays["values"])
    except (ValueError, KeyError) as error:
        raise ExpectedError(path, error) from error


def _unpacked(index: Mapping[str, Any], cases: Array, values: Array) -> dict[str, KnownMistake]:
    taken = [0, 0]

    def part(count: int, width: int) -> Observation:
        first, start = taken
        taken[:] = first + count, start + count * width
        own = values[start : taken[1]].reshape(count, width)
        return Observation(cases[first : taken[0]], own)

    return {
        name: KnownMistake(
            row["exercise"],
            {
                check: {key: part(*shape) for key, shape in parts.items()}
                for check, parts in row["checks"].items()
            },
        )
        for name, row in index.items()
    }
