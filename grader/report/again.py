"""results.json told again: in another language, or after a sentence of messages/ was mended.

Nothing is built or run. A sentence of which messages/ knows no more, an older project's, stays as
it was written.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from grader.checking import reproducer
from grader.course import exercises
from grader.course.message import Message, UserError
from grader.course.texts import Texts
from grader.evaluation.records import Words
from grader.evaluation.wording import Wording
from grader.report import results, schema
from grader.report.results import Row

T = TypeVar("T")
_NONE: dict[int, str] = {}
_OPTIONAL = ("hints", "places", "pixel")  # of a check


class ResultsError(UserError):
    """A file that holds no results of ours: a sentence of [again] in messages/."""

    code = 2


def read(path: Path) -> dict[str, Any]:
    """Return the content of a results.json of this version or of an older one.

    Raises ResultsError.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ResultsError("again.unread", path=path, error=error.strerror) from error
    except (ValueError, RecursionError) as error:
        raise ResultsError("again.broken", path=path, error="JSON") from error
    if fault := next(schema.faults(content), ""):
        raise ResultsError("again.broken", path=path, error=fault)
    return dict(content)


def told(content: Row, texts: Texts, hint: int = 0) -> dict[str, Any]:
    """Return the content of results.json with the sentences of a language, as it is now.

    `hint` is the level of help; 0: the one that it had.
    """
    words = content.get("words", {})
    said = {"words": {**words, "expected": texts.get(reproducer.EXPECTED)}} if words else {}
    return {
        **content,
        **said,
        "language": texts.language,
        "build": _build(content["build"], words, texts),
        "notes": _sentences(content["notes"], words.get("notes", ()), texts),
        "exercises": [{**each, "title": _title(each, texts)} for each in content["exercises"]],
        "checks": [_check(each, words, texts, hint) for each in content["checks"]],
    }


def _build(build: Row, words: Row, texts: Texts) -> dict[str, Any]:
    meanings, rejected = words.get("meanings", {}), words.get("rejected", {})
    return {
        **build,
        "advice": _sentences(build.get("advice", []), words.get("advice", ()), texts),
        "errors": [
            {**each, "meaning": _sentence(each["meaning"], meanings.get(str(place)), texts)}
            for place, each in enumerate(build["errors"])
        ],
        "rejected": {
            name: _sentence(sentence, rejected.get(name), texts)
            for name, sentence in build["rejected"].items()
        },
    }


def _sentences(stored: Sequence[str], rows: Sequence[Row], texts: Texts) -> list[str]:
    """Return sentences told again, of which each has its message, or else none of them has."""
    if len(rows) != len(stored):
        return [*stored]
    return [_sentence(*each, texts) for each in zip(stored, rows, strict=True)]


def _sentence(stored: str, row: Row | None, texts: Texts) -> str:
    return _or(stored, lambda: texts.told(Message.of_row(row))) if row else stored


def _or(stored: T, tell: Callable[[], T]) -> T:
    """Return what is told now; what is stored where a key or a value is not known any more."""
    try:
        return tell()
    except (LookupError, ValueError, TypeError, AttributeError):
        return stored


def _title(exercise: Row, texts: Texts) -> str:
    return _or(
        str(exercise["title"]),
        lambda: texts.title(exercises.load().exercise(exercise["id"])),
    )


def _check(check: Row, common: Row, texts: Texts, level: int) -> dict[str, Any]:
    program = reproducer.told_again(check["reproducer"], common.get("expected", ""), texts)
    words = _or(None, lambda: Words.of_row(check["words"]))
    if words is None:
        return dict(check)
    if words.level and level:
        words = replace(words, level=level)
    told = Wording(check["id"], check["mistakes"], words, texts)
    hint, hints, pixel = _or("", told.hint), _or(_NONE, told.hints), check.get("pixel")
    again = {
        **{name: value for name, value in check.items() if name not in _OPTIONAL},
        "title": _or(check["title"], told.title),
        "message": _or(check["message"], told.message),
        "hint": hint or check["hint"],
        "note": _or(check["note"], told.note),
        "reproducer": program,
        "words": {**check["words"], **({"level": words.level} if words.level else {})},
        "hints": results.hint_rows(hints) if hint else check.get("hints"),
        "places": _or(check.get("places"), told.places),
        "pixel": {**pixel, "told": _or(pixel["told"], told.pixel)} if pixel else None,
    }
    return {name: value for name, value in again.items() if value or name not in _OPTIONAL}
