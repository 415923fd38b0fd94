"""Sentences for the person at the terminal, by key, from the folders of messages/."""

from __future__ import annotations

import os
from functools import cache
from typing import Any

from grader.course import settings
from grader.course.exercises import Exercise, ManifestError, read_toml
from grader.course.message import Message
from grader.course.settings import COMPLETE, LANGUAGES, MESSAGES

__all__ = ["LANGUAGES", "Texts", "preferred", "sentences"]

FOLDER = MESSAGES
FIRST_HINT = 2


class Texts:
    """The sentences of one language."""

    def __init__(self, language: str) -> None:
        self.language = language
        self._sentences = sentences(language)

    def say(self, key: str, **values: object) -> str:
        """Return the sentence of a key such as "submission.no_folder", with its values.

        A value may be a Message, or some, words of the language too; a float is written as the
        language writes it. Raises KeyError for an unknown key: a test holds keys and sentences
        together.
        """
        return self._sentences[key].format_map({k: self._word(v) for k, v in values.items()})

    def told(self, message: Message) -> str:
        """Return the sentence of a message, and those of what is added to it."""
        return " ".join(self.say(each.key, **each.values) for each in (message, *message.then))

    def get(self, key: str, default: str = "") -> str:
        """Return the sentence of a key that may have none."""
        return self._sentences.get(key, default)

    def _word(self, value: object) -> object:
        if isinstance(value, Message):
            return self.told(value)
        if isinstance(value, tuple) and all(isinstance(each, Message) for each in value):
            return "".join(map(self.told, value))
        return self.number(value) if isinstance(value, float) else value

    def number(self, value: float) -> str:
        """Return a number as it is written in the language, with as few decimals as it needs."""
        text = f"{value:g}"
        return text.replace(".", self.say("language.decimal"))

    def title(self, exercise: Exercise) -> str:
        """Return the title of an exercise. Raises KeyError."""
        return self.say(f"exercise.{exercise.id}")

    def tp_title(self, tp: int) -> str:
        """Return the title of a TP. Raises KeyError for one that there is not."""
        return self.say(f"exercise.TP{tp}")

    def age(self, seconds: int, date: str) -> str:
        """Return how long ago a file was written; its date when that is long ago, or to come."""
        for key, unit, below in (
            ("age.now", 1, 60),
            ("age.minutes", 60, 3600),
            ("age.hours", 3600, 2 * 86400),
            ("age.days", 86400, 30 * 86400),
        ):
            if 0 <= seconds < below:
                return self.say(key, count=seconds // unit)
        return self.say("age.date", date=date)


def preferred(asked: str = "", otherwise: str = "") -> str:
    """Return the language asked for, or that of MRT_LANG; another one otherwise, the course's."""
    names = ((asked or os.environ.get("MRT_LANG", ""))[:2].lower(), otherwise)
    return next((name for name in names if name in LANGUAGES), settings.load().language)


@cache
def sentences(language: str) -> dict[str, str]:
    """Return every sentence of a language by its dotted key. Raises ManifestError.

    What a language has not is said in English, unless it is one of the course's own.
    """
    if language not in COMPLETE:
        return sentences(COMPLETE[-1]) | _written(language)
    return _written(language)


def _written(language: str) -> dict[str, str]:
    found: dict[str, str] = {}
    for path in sorted((FOLDER / language).glob("*.toml")):
        table = read_toml(path)
        table.pop("comment", None)  # of C files: see authoring/translation.py
        own = dict(_flat("", table))
        if twice := sorted(set(own) & set(found)):
            raise ManifestError(f"{path.name}: {twice[0]} stands in another file too; keep one")
        found |= own
    return found


def _flat(prefix: str, table: dict[str, Any]) -> list[tuple[str, str]]:
    rows: list[tuple[str, str]] = []
    for name, value in table.items():
        key = f"{prefix}{name}"
        if isinstance(value, list):  # hints by their level; the first level is a question
            value = {str(level): text for level, text in enumerate(value, FIRST_HINT)}
        rows += _flat(f"{key}.", value) if isinstance(value, dict) else [(key, value)]
    return rows
