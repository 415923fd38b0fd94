"""A new known mistake: what it changes, and its sentences in every language."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence

from grader.authoring.new.check import messages_of
from grader.authoring.new.edits import MARK, Edit, NewError, behind, read
from grader.authoring.specimens.mistakes import Mistake
from grader.authoring.specimens.wrong import WORTH
from grader.course.exercises import ROOT, Exercise, Manifest, read_toml
from grader.course.nearest import nearest
from grader.course.settings import COMPLETE
from grader.course.texts import Texts

FOLDER = "reference/mistakes"
SHARES = f"{FOLDER}/{WORTH}"
_ID = re.compile(r"[a-z]\w*")


def edits(
    name: str, exercise: str, worth: str, rules: Manifest, known: Sequence[Mistake]
) -> list[Edit]:
    """Return the files of a new mistake of an exercise. Raises NewError."""
    ids = [each.id for each in rules.exercises if each.checks]
    if not _ID.fullmatch(name):
        raise NewError(f"MISTAKE={name}: an id is like sphere_far_root")
    if name in {each.id for each in known}:
        raise NewError(f"MISTAKE={name}: there is one already, in {FOLDER}")
    if exercise not in ids:
        near = nearest(exercise, ids)
        raise NewError(f"EXERCISE={exercise}: name the one of the mistake; the nearest is {near}")
    worths = read_toml(ROOT / SHARES)["worth"]
    if worth not in worths:
        raise NewError(f"WORTH={worth}: one of {', '.join(worths)}, in {SHARES}")
    own = [each.id for each in known if each.exercise == exercise]
    chosen = rules.exercise(exercise)
    sentences = [_messages(name, chosen, language, own) for language in COMPLETE]
    return [_change(name, chosen, worth, own), *sentences]


def _change(name: str, exercise: Exercise, worth: str, own: list[str]) -> Edit:
    """Return the exercise's file with a mistake in the first line of its solution."""
    path = f"{FOLDER}/{exercise.id}.toml"
    line = json.dumps(_first_line(exercise), ensure_ascii=False)
    entry = (
        f'[mistake.{name}]\nworth = "{worth}"\nfunction = "{exercise.functions[0]}"\n'
        f"before = {line} # {MARK} what stands there once\n"
        f"after = {line} # {MARK} the mistake in its place\n"
    )
    text = read(path)
    if not own:
        return Edit(path, f"{entry}\n{text}")
    return Edit(path, behind(path, text, rf"^\[mistake\.{own[-1]}\]\n(?:.+\n)+", f"\n{entry}"))


def _first_line(exercise: Exercise) -> str:
    source = f"reference/{exercise.file}"
    lines = read(source).splitlines()
    begin = re.compile(rf"\s*/\* BEGIN SOLUTION {re.escape(exercise.id)}[ :]")
    start = next((k for k, line in enumerate(lines) if begin.match(line)), None)
    if start is None:
        raise NewError(f"{source}: no solution of {exercise.id} is marked there")
    if MARK in lines[start + 1]:
        raise NewError(f"{source}: write the solution of {exercise.id} first")
    return lines[start + 1].strip()


def _in_list(path: str, text: str, own: list[str], entry: str) -> str:
    """Return the text with an entry behind the last of the same exercise, or at the end."""
    if not own:
        return f"{text.rstrip()}\n{entry}"
    return behind(path, text, rf"^\[mistake\.{own[-1]}\]\n(?:.+\n)+", entry)


def _messages(name: str, exercise: Exercise, language: str, own: list[str]) -> Edit:
    """Return the sentences, in the exercise's own file where it has one."""
    say, parts = Texts(language).say, ("title", "question", "hint")
    rows = [f'{part} = "" # {MARK} {say(f"new.mistake_{part}")}\n' for part in parts]
    entry = "".join([f"\n[mistake.{name}]\n", *rows])
    path = messages_of(exercise, language, "mistakes")
    return Edit(path, _in_list(path, read(path), own, entry))
