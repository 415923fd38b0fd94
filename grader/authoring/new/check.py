"""A new check: a line of exercises.toml, and what it says in every language."""

from __future__ import annotations

import re
from collections.abc import Mapping

from grader.authoring.expected.suites import recipes
from grader.authoring.new.edits import (
    MARK,
    Edit,
    NewError,
    behind,
    created,
    in_table,
    read,
)
from grader.course.exercises import ROOT, Exercise, Manifest
from grader.course.nearest import nearest
from grader.course.texts import LANGUAGES

MANIFEST = "grader/course/exercises.toml"
MESSAGES = "grader/course/messages"
_ID = re.compile(r"tp\d\.[a-z_]\w*\.[a-z_]\w*")
TITLE: Mapping[str, str] = {
    "fr": "ce qui est vérifié, en une affirmation",
    "en": "what is looked at, as a statement",
}
QUESTION: Mapping[str, str] = {
    "fr": "une question qui fait regarder au bon endroit",
    "en": "a question that makes one look at the right place",
}
HINTS: Mapping[str, str] = {
    "fr": "deux indices : où regarder, puis presque la réponse",
    "en": "two hints: where to look, then nearly the answer",
}


def edits(check: str, suite: str, rules: Manifest) -> list[Edit]:
    """Return the files of a new check that compares the answers to a suite. Raises NewError."""
    if not _ID.fullmatch(check):
        raise NewError(f"CHECK={check}: an id is like tp2.intersect_plane.range")
    if check in rules.checks():
        raise NewError(f"CHECK={check}: there is one already, in {MANIFEST}")
    exercise = _exercise(check, rules)
    about = {*exercise.functions, *(each.subject for each in exercise.checks)}
    if suite.partition(".")[0] not in about or not suite.partition(".")[2]:
        names = " or ".join(f"{name}." for name in sorted(about - {"scene"}))
        raise NewError(f"SUITE={suite}: one of {exercise.id} begins with {names}")
    line = (
        f'"{check}" = {{ weight = 1, compares = ["result"], suites = ["{suite}"] }}'
        f" # {MARK} its weight, and what is compared (or a helper: see the head of this file)\n"
    )
    text = behind(MANIFEST, read(MANIFEST), rf'^"{exercise.checks[-1].id}" = .*\n', line)
    sentences = [_messages(check, exercise, language) for language in LANGUAGES]
    return [Edit(MANIFEST, text), *suite_edits(suite), *sentences]


def messages_of(exercise: Exercise, language: str, file: str) -> str:
    """Return where sentences of an exercise stand: in a file of its own, or in that of all."""
    own = f"{MESSAGES}/{language}/{exercise.functions[0]}.toml"
    return own if (ROOT / own).is_file() else f"{MESSAGES}/{language}/{file}.toml"


def suite_edits(suite: str) -> list[Edit]:
    """Return the file of a suite that nothing makes yet, and none of one that is there."""
    if suite in {each.name for each in recipes()}:
        return []
    function, _, name = suite.partition(".")
    path = f"grader/authoring/expected/vectors/{function}_{name}.py"
    return [created(path, _suite(function, suite))]


def table_lines(check: str, language: str) -> dict[str, str]:
    """Return the entries of a check in the tables of a language's messages."""
    return {
        "title": f'"{check}" = "" # {MARK} {TITLE[language]}\n',
        "question": f'"{check}" = "" # {MARK} {QUESTION[language]}\n',
        "hint": f'"{check}" = ["", ""] # {MARK} {HINTS[language]}\n',
    }


def _exercise(check: str, rules: Manifest) -> Exercise:
    tp, subject, _ = check.split(".")
    own = [each for each in rules.exercises if tp == f"tp{each.tp}" and each.checks]
    for each in own:
        if subject in (
            *each.functions,
            *(one.subject for one in each.checks if not one.is_picture),
        ):
            return each
    known = [name for each in own for name in each.functions]
    raise NewError(
        f"CHECK={check}: no exercise of {tp.upper()} is about {subject};"
        f" the nearest is {nearest(subject, known) or 'none'}"
    )


def _messages(check: str, exercise: Exercise, language: str) -> Edit:
    path = messages_of(exercise, language, "checks")
    text = read(path)
    for table, entry in table_lines(check, language).items():
        text = in_table(path, text, table, check, entry)
    return Edit(path, text)


def _suite(function: str, suite: str) -> str:
    return f'''"""Inputs of {function}."""

from __future__ import annotations

from grader.authoring.expected.vectors.maker import Maker, Question, Recipe, floats, stack
from grader.checking.expected_data import Batch


def recipes() -> list[Recipe]:
    """Return how the suites of this file are made."""
    # {MARK} how far right answers may be from the reference's, and why
    return [Recipe("{suite}", _questions, 1e-4, "a few float operations")]


def _questions(m: Maker) -> list[Question]:
    # {MARK} a column of inputs for each parameter of the function, simple round ones first
    x = stack(floats([0, 1, 2]), m.uniform(0, 9, 20))
    return [Question(Batch("{function}", {{"x": x}}, m.world()))]
'''
