"""A new check: a line of exercises.toml, and what it says in every language."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence

from grader.authoring.expected.suites import recipes
from grader.authoring.new.edits import MARK, Edit, NewError, behind, in_table, read
from grader.checking.pictures.plan import everything
from grader.course.exercises import CORE, ROOT, Exercise, Manifest
from grader.course.nearest import nearest
from grader.course.settings import COMPLETE
from grader.course.texts import Texts

MANIFEST = "grader/course/exercises.toml"
MESSAGES = "grader/course/messages"
_ID = re.compile(r"tp\d\.[a-z_]\w*\.[a-z_]\w*")


def edits(check: str, suite: str, rules: Manifest) -> list[Edit]:
    """Return the files of a new check that compares the answers to a suite. Raises NewError."""
    _expect_new(check, rules)
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
    if suite not in {each.name for each in recipes()}:
        block = rf'^id = "{re.escape(exercise.id)}"\n(?:.+\n)*'
        text = behind(MANIFEST, text, block, suite_lines(suite, parameters(suite)))
    return _with_messages(check, exercise, text)


def picture_edits(check: str, picture: str, name: str, rules: Manifest) -> list[Edit]:
    """Return the files of a new check that judges a picture. Raises NewError."""
    _expect_new(check, rules)
    known = {each.name for each in everything()}
    if picture not in known:
        raise NewError(f"PICTURE={picture}: the nearest is {nearest(picture, known)}")
    own = {each.id: each for each in rules.exercises if check.startswith(f"tp{each.tp}.scene.")}
    if name not in own:
        near = nearest(name, own) or "none: the check's id is like tp4.scene.shadows_4"
        raise NewError(f"EXERCISE={name}: whose picture it is; the nearest is {near}")
    # What draws one picture of an exercise draws the others.
    like = next((each for each in own[name].checks if each.is_picture), None)
    needs = json.dumps([*(like.needs if like else own[name].depends)])
    line = (
        f'"{check}" = {{ weight = 1, picture = "{picture}", needs = {needs} }}'
        f" # {MARK} its weight, and whose functions it needs (see the head of this file)\n"
    )
    last = rf'^"{own[name].checks[-1].id}" = .*\n'
    return _with_messages(check, own[name], behind(MANIFEST, read(MANIFEST), last, line))


def _expect_new(check: str, rules: Manifest) -> None:
    if not _ID.fullmatch(check):
        raise NewError(f"CHECK={check}: an id is like tp2.intersect_plane.range")
    if check in rules.checks():
        raise NewError(f"CHECK={check}: there is one already, in {MANIFEST}")


def _with_messages(check: str, exercise: Exercise, manifest: str) -> list[Edit]:
    sentences = [_messages(check, exercise, language) for language in COMPLETE]
    return [Edit(MANIFEST, manifest), *sentences]


def messages_of(exercise: Exercise, language: str, file: str) -> str:
    """Return where sentences of an exercise stand: in a file of its own, or in that of all."""
    own = f"{MESSAGES}/{language}/{exercise.functions[0]}.toml"
    return own if (ROOT / own).is_file() else f"{MESSAGES}/{language}/{file}.toml"


def suite_lines(suite: str, names: Sequence[str]) -> str:
    """Return the lines of a suite whose inputs are numbers, for parameters of its function."""
    numbers = "its numbers, simple round ones first (of a struct, a line for each field)"
    return f'''[exercise.suites."{suite}"]
within = 1e-4
why = "a few float operations" # {MARK} how far right answers may be from the reference's, and why
drawn = 20
''' + "".join(
        f"inputs.{name} = {{ first = [], low = 0, high = 9 }} # {MARK} {numbers}\n"
        for name in names
    )


def parameters(suite: str) -> list[str]:
    """Return the parameters of a suite's function, as the headers name them."""
    prototype = re.compile(rf"\b{suite.partition('.')[0]}\(([^)]*)\);")
    for header in sorted(CORE.glob("*.h")):
        if found := prototype.search(header.read_text(encoding="utf-8")):
            return re.findall(r"(\w+)(?=,|$)", found[1])
    return []


def table_lines(check: str, language: str) -> dict[str, str]:
    """Return the entries of a check in the tables of a language's messages."""
    empty = {"title": '""', "question": '""', "hint": '["", ""]'}
    say = Texts(language).say
    return {
        name: f'"{check}" = {value} # {MARK} {say(f"new.{name}")}\n'
        for name, value in empty.items()
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
