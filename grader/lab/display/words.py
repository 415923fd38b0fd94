"""The sentences of the notebooks' tools, in the language of the notebook."""

from __future__ import annotations

from pathlib import Path

from grader.course.texts import LANGUAGES, Texts, preferred


def texts() -> Texts:
    """Return the sentences of the notebook's language.

    That is the language its folder is named after, or else that of MRT_LANG, or the course's.
    """
    folder = Path.cwd().name
    return Texts(folder if folder in LANGUAGES else preferred())


def say(key: str, **values: object) -> str:
    """Return the sentence of a key of [lab] in messages/, with its values."""
    return texts().say(f"lab.{key}", **values)
