"""Sentences of the tools that run before any package is there: `setup.toml` of messages/.

A language is a folder of `grader/course/messages/`; what it has not is said in English. The file is
plain enough for sentences.sh too: one `key = "text"` a line. TOML needs a package on Python 3.10.
"""

from __future__ import annotations

import os
import re
import sys
from functools import cache
from pathlib import Path

from grader.setup.folding import put

MESSAGES = Path(__file__).resolve().parent.parent / "course" / "messages"
FIRST, LAST = "fr", "en"  # when nothing is asked for; where a language has no such sentence
_LINE = re.compile(r'(\w+) = "(.*)"')


def say(key: str, **values: object) -> str:
    """Return the sentence of a key such as "setup.waiting", in the person's language (MRT_LANG).

    A workbook whose update was cut off may have lost it: the key and the values are said then.
    """
    known = _sentences(language())
    section, _, name = key.partition(".")
    found = known.get(name) if section == "setup" else None
    return found.format_map(values) if found else " ".join([key, *map(str, values.values())])


def tell(key: str, **values: object) -> None:
    """Print a sentence on stderr."""
    put(say(key, **values), sys.stderr)


def language() -> str:
    """Return the language of the person at the terminal."""
    asked = os.environ.get("MRT_LANG", "")[:2].lower()
    return asked if asked and (MESSAGES / asked).is_dir() else FIRST


@cache
def _sentences(language: str) -> dict[str, str]:
    return _read(LAST) | _read(language)


def _read(language: str) -> dict[str, str]:
    try:
        lines = (MESSAGES / language / "setup.toml").read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError):
        return {}
    found = filter(None, map(_LINE.fullmatch, lines))
    return {each[1]: re.sub(r"\\(.)", _escaped, each[2]) for each in found}


def _escaped(found: re.Match[str]) -> str:
    return "\n" if found[1] == "n" else found[1]
