"""A new known mistake: a patch, its entry, and its sentences in every language."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from grader.authoring.new.check import messages_of
from grader.authoring.new.edits import MARK, Edit, NewError, behind, created, read
from grader.authoring.specimens.mistakes import Mistake
from grader.course.exercises import ROOT, Exercise, Manifest, read_toml
from grader.course.nearest import nearest
from grader.course.texts import LANGUAGES

FOLDER = "reference/mistakes"
LIST = f"{FOLDER}/mistakes.toml"
_ID = re.compile(r"[a-z]\w*")
_SAYS: Mapping[str, tuple[str, str, str]] = {
    "fr": ("l'erreur, en une phrase", "une question qui la fait voir", "ce qui la corrige"),
    "en": ("the mistake, as a sentence", "a question that shows it", "what mends it"),
}


def edits(
    name: str, exercise: str, worth: str, rules: Manifest, known: Sequence[Mistake]
) -> list[Edit]:
    """Return the files of a new mistake of an exercise. Raises NewError."""
    ids = [each.id for each in rules.exercises if each.checks]
    if not _ID.fullmatch(name):
        raise NewError(f"MISTAKE={name}: an id is like sphere_far_root")
    if name in {each.id for each in known}:
        raise NewError(f"MISTAKE={name}: there is one already, in {LIST}")
    if exercise not in ids:
        near = nearest(exercise, ids)
        raise NewError(f"EXERCISE={exercise}: name the one of the mistake; the nearest is {near}")
    worths = read_toml(ROOT / LIST)["worth"]
    if worth not in worths:
        raise NewError(f"WORTH={worth}: one of {', '.join(worths)}, in {LIST}")
    own = [each.id for each in known if each.exercise == exercise]
    entry = f'\n[mistake.{name}]\nexercise = "{exercise}"\nworth = "{worth}"\n'
    text = _in_list(LIST, read(LIST), own, entry)
    chosen = rules.exercise(exercise)
    sentences = [_messages(name, chosen, language, own) for language in LANGUAGES]
    return [_patch(name, chosen), Edit(LIST, text), *sentences]


def _in_list(path: str, text: str, own: list[str], entry: str) -> str:
    """Return the text with an entry behind the last of the same exercise, or at the end."""
    if not own:
        return f"{text.rstrip()}\n{entry}"
    return behind(path, text, rf"^\[mistake\.{own[-1]}\]\n(?:.+\n)+", entry)


def _messages(name: str, exercise: Exercise, language: str, own: list[str]) -> Edit:
    """Return the sentences, in the exercise's own file where it has one."""
    title, question, hint = _SAYS[language]
    entry = (
        f'\n[mistake.{name}]\ntitle = "" # {MARK} {title}\n'
        f'question = "" # {MARK} {question}\nhint = "" # {MARK} {hint}\n'
    )
    path = messages_of(exercise, language, "mistakes")
    return Edit(path, _in_list(path, read(path), own, entry))


def _patch(name: str, exercise: Exercise) -> Edit:
    """Return a patch of the first line of the exercise's solution."""
    source = f"reference/{exercise.file}"
    lines = read(source).splitlines()
    begin = re.compile(rf"\s*/\* BEGIN SOLUTION {re.escape(exercise.id)}[ :]")
    start = next((k for k, line in enumerate(lines) if begin.match(line)), None)
    if start is None:
        raise NewError(f"{source}: no solution of {exercise.id} is marked there")
    first = start + 1
    if MARK in lines[first]:
        raise NewError(f"{source}: write the solution of {exercise.id} first")
    hunk = [f" {lines[start]}", f"-{lines[first]}"]
    hunk += [f"+{lines[first]} /* {MARK} the mistake, in the place of right lines */"]
    hunk += [f" {lines[first + 1]}"]
    head = f"--- a/{source}\n+++ b/{source}\n@@ -{first},3 +{first},3 @@\n"
    return created(f"{FOLDER}/{name}.patch", head + "\n".join(hunk) + "\n")
