"""The comments of what students get, in the course's language.

The files that students read are written with English comments. `reference/comments/fr/PATH.toml`
says each of them in French, beside the English one: a comment that changes needs a new translation,
and `make release` stops until it has one. Only comments are replaced, so the code stays the same.
Contracts of exercises stand with what else is said of these, in grader/course/messages/fr/.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

from grader.course.exercises import ROOT, read_toml
from grader.course.message import UserError
from grader.course.settings import MESSAGES
from grader.setup import c_text

FOLDER = ROOT / "reference" / "comments"
CONTRACTS = "core_c/exercises.h"
SOURCE = "en"  # what the files are written in

# Whole lines, but for those that end in nothing else: `##` introduces the help of make.
_HASH = re.compile(r"^#(?!#).*(?:\n#(?!#).*)*", re.MULTILINE)
_RULE = re.compile(r"(?P<left>[=-]{3,} )?(?P<text>.*?)(?P<right> [=-]{3,})?")


class TranslationError(UserError):
    """A comment without its translation, or the contrary: a sentence of [release] in messages/."""


def is_read(path: str) -> bool:
    """Say whether students read a file of the archive for what it says to them in comments."""
    name = path.rsplit("/", 1)[-1]
    return not path.startswith("grader/") and (
        name in ("Makefile", "AUTEURS.txt") or name.endswith((".c", ".h"))
    )


def translated(files: Mapping[str, bytes], language: str) -> dict[str, bytes]:
    """Return the files with their comments in a language. Raises TranslationError."""
    if language == SOURCE:
        return dict(files)
    return {
        path: in_language(path, content.decode(), language).encode() if is_read(path) else content
        for path, content in files.items()
    }


def in_language(path: str, text: str, language: str) -> str:
    """Return a file's text with its comments in a language. Raises TranslationError."""
    known = catalogue(path, language)
    met: set[str] = set()

    def replaced(found: re.Match[str]) -> str:
        if found.groupdict().get("literal"):
            return found[0]
        own = plain(found[0])
        met.add(own)
        if own not in known:
            raise _problem("release.untranslated", path, language, own)
        column = found.start() - text.rfind("\n", 0, found.start()) - 1
        return _dressed(found[0], known[own], column)

    result = _pattern(path).sub(replaced, text)
    for own in known:
        if own not in met:
            raise _problem("release.stale_comment", path, language, own)
    return result


def catalogue(path: str, language: str) -> dict[str, str]:
    """Return the translations of a file's comments, by what they translate."""
    if path == CONTRACTS:
        places = sorted((MESSAGES / language).glob("*.toml"))
    else:
        places = [each for each in (FOLDER / language / f"{path}.toml",) if each.is_file()]
    pairs = [pair for place in places for pair in read_toml(place).get("comment", [])]
    return {each[SOURCE]: each[language] for each in pairs if {SOURCE, language} <= {*each}}


def comments(path: str, text: str) -> Iterator[str]:
    """Yield the comments of a file, as `plain` gives them."""
    for found in _pattern(path).finditer(text):
        if not found.groupdict().get("literal"):
            yield plain(found[0])


def without_comments(path: str, text: str) -> str:
    """Return what of a file is no comment."""
    return _pattern(path).sub(lambda found: found.groupdict().get("literal") or "", text)


def plain(comment: str) -> str:
    """Return the lines of a comment alone, without what stands around them."""
    if comment.startswith("#"):
        return "\n".join(line.removeprefix("#").strip() for line in comment.split("\n"))
    lines = [re.sub(r"^\s*\* ?", "", line) for line in comment[2:-2].strip().split("\n")]
    rule = _RULE.fullmatch(lines[0])
    assert rule  # it matches anything
    return "\n".join([rule["text"], *lines[1:]])


def _dressed(comment: str, text: str, column: int) -> str:
    """Return a text as a comment of the same form as the one whose place it takes."""
    lines = text.split("\n")
    if comment.startswith("#"):
        return "\n".join(f"# {line}".rstrip() for line in lines)
    first = comment[2:-2].strip().split("\n")[0]
    rule = _RULE.fullmatch(first)
    assert rule  # it matches anything
    lines[0] = f"{rule['left'] or ''}{lines[0]}"
    if rule["right"]:  # the rule ends where it did
        lines[0] = f"{lines[0]} ".ljust(len(first), rule["right"][-1])
    margin = f"\n{' ' * column} *"
    end = f"{margin}/" if comment.split("\n")[-1].strip() == "*/" else " */"
    return "/* " + margin.join([lines[0], *(f" {each}".rstrip() for each in lines[1:])]) + end


def _pattern(path: str) -> re.Pattern[str]:
    return c_text.SILENT if path.endswith((".c", ".h")) else _HASH


def _problem(key: str, path: str, language: str, own: str) -> TranslationError:
    place = MESSAGES / language / "contracts.toml"
    if path != CONTRACTS:
        place = FOLDER / language / f"{path}.toml"
    file, text = place.relative_to(ROOT), own.split("\n", 1)[0]
    return TranslationError(key, path=path, file=file, text=text)
