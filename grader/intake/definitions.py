"""Where a function is defined in the student's files, by their text: no compiler is asked."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache

from grader.course import exercises
from grader.course.exercises import Exercise
from grader.setup import c_text

_BRACE = re.compile(r"[{}]")


@dataclass(frozen=True)
class Definition:
    """Where a function is: its file, its first line (from 1), its text."""

    file: str
    line: int
    text: str


def find(function: str, files: Mapping[str, str]) -> Definition | None:
    """Look for the definition of a function in C files by name, in its own file first."""
    for name in _order(function, files):
        span = _span(files[name], function)
        if span is not None:
            line = files[name].count("\n", 0, span[0]) + 1
            return Definition(name, line, files[name][span[0] : span[1]])
    return None


def changed(before: Mapping[str, str], now: Mapping[str, str]) -> list[Exercise]:
    """Return the exercises with a function that is no more what it was in C files by name.

    What comments and the space around words become does not count.
    """
    return [each for each in exercises.load().exercises if _code(each, before) != _code(each, now)]


def _code(exercise: Exercise, files: Mapping[str, str]) -> list[list[str]]:
    found = [find(each, files) for each in exercise.functions]
    return [c_text.without_comments(each.text).split() if each else [] for each in found]


def _order(function: str, files: Mapping[str, str]) -> Iterator[str]:
    rules = exercises.load()
    first = [each.file for each in rules.exercises if function in each.functions]
    others = [name for name in rules.student if name.endswith(".c")]
    return (name for name in dict.fromkeys([*first, *others, *sorted(files)]) if name in files)


def _span(text: str, function: str) -> tuple[int, int] | None:
    """Return where a definition begins and ends; braces in comments and strings do not count."""
    bare = _bare(text)
    if (head := _head(function).search(bare)) is None:
        return None
    depth = 0
    for brace in _BRACE.finditer(bare, head.end() - 1):
        depth += 1 if brace[0] == "{" else -1
        if depth == 0:
            return head.start(), brace.end()
    return None


@lru_cache(maxsize=8)  # one file is asked about each of its functions
def _bare(text: str) -> str:
    return c_text.blanked(text)


def _head(function: str) -> re.Pattern[str]:
    """Return what a definition begins with.

    Before the name only words and stars, a type: a call inside an if (...) { is no definition. What
    is between the parentheses is bounded, since a text may hold thousands that are never closed.
    """
    name = re.escape(function)
    return re.compile(rf"^[\w \t*]{{0,200}}\b{name}\s*\([^;{{}}]{{0,1000}}\)\s*\{{", re.MULTILINE)
