"""The contracts of exercises.h, sentence by sentence, and the programs that break each.

reference/mistakes/ has them, by exercise. `sentences` reads them from the header, so that one that
is added there, and has no program, is noticed.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from grader.authoring.specimens.edits import FunctionEdit
from grader.authoring.specimens.wrong import FOLDER, tables
from grader.course.exercises import CORE, malformed

HEADER = CORE / "exercises.h"
SAYS = "says"  # of a sentence that nothing can break: a title, an argument, a promise of the caller
_CONTRACT = re.compile(r"/\* (TP\d\.B?\d) - (.*?)\*/", re.DOTALL)
_ARGUMENT = re.compile(r"  \S+(?:, \S+)* +\S")
_END = re.compile(r"(?<=[.;])\s+(?=\S)")
_ASIDE = ("Handout ", "Check: ")  # where to read more, and the command that judges


class Breach(FunctionEdit):
    """The reference with one sentence of a contract broken."""


@dataclass(frozen=True)
class Sentence:
    """A sentence of an exercise's contract, and what is known of it."""

    exercise: str
    text: str
    broken_by: tuple[str, ...] = ()  # breaches and known mistakes
    allows: tuple[str, ...] = ()  # right programs


@dataclass(frozen=True)
class Contracts:
    """What the table says."""

    breaches: tuple[Breach, ...]
    sentences: tuple[Sentence, ...]


@cache
def load(folder: Path = FOLDER) -> Contracts:
    """Read the files of the exercises. Raises ManifestError."""
    breaches: list[Breach] = []
    told: list[Sentence] = []
    for exercise, path, data in tables(folder):
        try:
            own = data.get("breach", {})
            breaches += [Breach(name, exercise, **row) for name, row in own.items()]
            told += [_sentence(exercise, *each) for each in data["sentences"].items()]
        except (KeyError, TypeError, AttributeError) as error:
            raise malformed(path, error) from error
    return Contracts(tuple(breaches), tuple(told))


def _sentence(exercise: str, text: str, value: Any) -> Sentence:
    if value == SAYS:
        return Sentence(exercise, text)
    if isinstance(value, Mapping):
        return Sentence(
            exercise, text, tuple(value.get("broken_by", ())), tuple(value.get("allows", ()))
        )
    if not isinstance(value, list):
        raise TypeError(text)
    return Sentence(exercise, text, tuple(value))


def sentences(header: str) -> list[tuple[str, str]]:
    """Return the sentences of every contract in a header, each after its exercise."""
    return [
        (found[1], " ".join(each.split()))
        for found in _CONTRACT.finditer(header)
        for item in _items(found[2])
        for each in _END.split(item)
        if not each.startswith(_ASIDE)
    ]


def _items(body: str) -> Iterator[str]:
    """Yield paragraphs, and the lines that tell an argument each."""
    lines = [re.sub(r"^ \* ?", "", line) for line in body.splitlines()]
    parts: list[str] = []
    for line in lines:
        if not line.strip() or _ARGUMENT.match(line):
            yield from _joined(parts)
            parts = []
        parts.append(line.strip())
    yield from _joined(parts)


def _joined(parts: Sequence[str]) -> list[str]:
    text = " ".join(parts).strip()
    return [text] if text else []
