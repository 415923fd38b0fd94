"""Which checks a person means by K=: exercises, functions and checks by their names, no others.

It reads the manifest alone, so that a wrong name is told before anything is compiled.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Iterator, Sequence

from grader.console.parser import UsageError
from grader.course import settings
from grader.course.exercises import Check, Exercise, Manifest

# What pytest's own expressions are made of; as parts of names they would be in half of them.
_OPERATORS = ("and", "or", "not")


def choose(rules: Manifest, tp: int | None, keyword: str) -> frozenset[str]:
    """Return the checks that K= and TP= ask for: those that count, when neither says more.

    A word that is an exercise or a function means the whole exercise, its pictures too; one that is
    the name of a check, that check. A part of a name will do when nothing has the whole of it.
    Raises UsageError.
    """
    asked = [each for each in rules.exercises if _is_asked(each, tp)]
    words = [word for word in re.split(r"[\s,]+", keyword) if word]
    if not words:
        return frozenset(check.id for each in asked for check in each.checks)
    chosen: set[str] = set()
    for word in words:
        if word.lower() in _OPERATORS:
            raise UsageError("usage.bad_keyword", word=word)
        found = _meant(word.lower(), asked)
        if found is None:
            raise _unknown(word, rules, asked)
        chosen |= found
    if not chosen:
        raise UsageError("usage.no_checks", names=", ".join(words))
    return frozenset(chosen)


def _is_asked(exercise: Exercise, tp: int | None) -> bool:
    return settings.load().is_counted(exercise.tp) if tp is None else exercise.tp == tp


def _meant(word: str, asked: Sequence[Exercise]) -> set[str] | None:
    """Return the checks that a word means; None when it means nothing."""
    checks = [check for each in asked for check in each.checks]
    # Several exercises may be written in one function: the first is where it is begun.
    written = [each for each in asked if word in map(str.lower, each.functions)][:1]
    whole = [each for each in asked if each.id.lower() == word] or written
    whole = whole or [each for each in asked if word in _subjects(each)]
    if whole:
        return _ids(whole)
    if named := {each.id for each in checks if word in _names(each)}:
        return named
    if parts := [each for each in asked if _has_part(word, each)]:
        return _ids(parts)
    return {each.id for each in checks if word in each.id} or None


def _has_part(word: str, exercise: Exercise) -> bool:
    names = (*map(str.lower, exercise.functions), *_subjects(exercise))
    return exercise.id.lower().startswith(word) or any(word in name for name in names)


def _subjects(exercise: Exercise) -> set[str]:
    """Return what the checks of functions are called by: the function, or what it is about."""
    return {check.subject for check in exercise.checks if not check.is_picture}


def _names(check: Check) -> Iterator[str]:
    """Yield the ways to write a check's name: whole, without its TP, its end alone."""
    parts = check.id.split(".")
    yield from (".".join(parts[k:]) for k in range(len(parts)))


def _ids(exercises: Iterable[Exercise]) -> set[str]:
    return {check.id for each in exercises for check in each.checks}


def _unknown(word: str, rules: Manifest, asked: Sequence[Exercise]) -> UsageError:
    """Return the error of a word that means nothing here: where it does, or what there is."""
    elsewhere = [each for each in rules.exercises if each not in asked]
    tps = [tp for tp in _tps(elsewhere) if _meant(word.lower(), _of(elsewhere, tp)) is not None]
    if tps:
        return UsageError("usage.other_tp", word=word, tp=tps[0])
    near = difflib.get_close_matches(word, _functions(asked), 1, 0.8)
    rows = {tp: _functions(_of(asked, tp)) for tp in _tps(asked)}
    lines = (f"\n  TP{tp}  {', '.join(names)}" for tp, names in rows.items())
    key = "usage.no_match_but" if near else "usage.no_match"
    return UsageError(key, word=word, near="".join(near), names="".join(lines))


def _of(exercises: Iterable[Exercise], tp: int) -> list[Exercise]:
    return [each for each in exercises if each.tp == tp]


def _tps(exercises: Iterable[Exercise]) -> list[int]:
    return list(dict.fromkeys(each.tp for each in exercises))


def _functions(exercises: Iterable[Exercise]) -> list[str]:
    return list(dict.fromkeys(name for each in exercises for name in each.functions))
