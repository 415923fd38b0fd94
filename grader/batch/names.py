"""Names of persons, as forms, folders and sheets write them: when two of them may be the same."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from difflib import SequenceMatcher

from grader.batch.records import Member
from grader.intake.authors import LETTERS

CLOSE = 0.8  # of two words, the share of letters that makes one a slip of the pen for the other
LEAST_LETTERS = 4  # of a word in which a slip is looked for


def words_of(name: str) -> list[str]:
    """Return the words of a name, without case and accents."""
    plain = unicodedata.normalize("NFKD", name.translate(LETTERS).casefold())
    letters = "".join(each for each in plain if not unicodedata.combining(each))
    return re.findall(r"[^\W_]+", letters)


def key_of(name: str) -> str:
    """Return a name without case, accents and order: what two spellings of it share."""
    return " ".join(sorted(words_of(name)))


def letters_of(name: str) -> str:
    """Return the letters of a name in their order, without anything between them."""
    return "".join(words_of(name))


def is_folder_of(label: str, name: str) -> bool:
    """Say whether a folder's name is a person's or a group's, as Moodle cleans it.

    Moodle drops quotes and the like; an archive may have lost the letters that are not ASCII.
    """
    if letters_of(label) == letters_of(name):
        return bool(letters_of(name))
    label, name = (unicodedata.normalize("NFC", each) for each in (label, name))
    kept = _ascii(name)
    return not name.isascii() and _ascii(label) == kept and bool(kept or not letters_of(label))


def _ascii(name: str) -> str:
    return re.sub(r"[^A-Za-z0-9]", "", name).casefold()


def is_alike(one: str, other: str) -> bool:
    """Say whether two names may be one person's: all the words of the shorter are in the other.

    An initial stands for a word, and a word may hold a slip of the pen.
    """
    short, long = sorted((words_of(one), words_of(other)), key=len)
    if not short:
        return False
    left = list(long)
    for word in short:
        found = _match(word, left)
        if found is None:
            return "".join(short) == "".join(long)
        left.remove(found)
    return True


def _match(word: str, words: Sequence[str]) -> str | None:
    if word in words:
        return word
    for each in words:
        if min(len(word), len(each)) == 1 and word[0] == each[0]:
            return each
    close = [each for each in words if min(len(word), len(each)) >= LEAST_LETTERS]
    return next(
        (each for each in close if SequenceMatcher(None, word, each).ratio() >= CLOSE), None
    )


def digits_of(number: str) -> str:
    """Return a student's number as it is compared: its digits, whatever letters stand around."""
    return re.sub(r"\D", "", number) or number.casefold()


def is_named(member: Member, name: str) -> bool:
    """Say whether a setting is about a person: by the number or the name that it gives."""
    by_number = member.number != "" and digits_of(name) == digits_of(member.number)
    return by_number or (key_of(name) != "" and key_of(name) == key_of(member.name))
