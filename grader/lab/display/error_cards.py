"""What is shown when the student's code does not build, does not come back, or prints."""

from __future__ import annotations

import re
from pathlib import Path

from grader.build import diagnostics
from grader.build.diagnostics import Diagnostic
from grader.build.records import BuildResult
from grader.execution import death_messages
from grader.execution.records import Death
from grader.execution.session import Session
from grader.lab.display.card import Shown, card, code, escape, note, stack
from grader.lab.display.links import link
from grader.lab.display.stopped import Printed
from grader.lab.display.words import say, texts

MAX_ERRORS = 3
MAX_LINES, MAX_COLUMNS = 40, 200  # of what one call printed
_INCLUDED_FROM = re.compile(r"\bfrom ([\w.-]+:\d+):$", re.MULTILINE)
_LOADER = "symbol lookup error"
AROUND = 2  # lines shown before and after the one that stopped


def sentence(key: str, **values: object) -> Shown:
    """Return a card with the sentence of a key."""
    return note(texts().say(key, **values), "bad")


def remark(text: str) -> Shown:
    """Return a card with a remark on the files."""
    return note(text)


def not_built(folder: Path, result: BuildResult, head: str) -> Shown:
    """Return the compiler's first errors below a sentence: place, meaning, line and caret."""
    errors = diagnostics.errors(result.log)
    parts = [_error(folder, each) for each in errors[:MAX_ERRORS]]
    if not errors:
        parts = _elsewhere(folder, result.log)
    if len(errors) > MAX_ERRORS:
        parts.append(_line(say("more_errors", count=len(errors) - MAX_ERRORS)))
    inside = stack([_line(head), *parts])
    return card(inside.html, inside.text, "bad")


def died(folder: Path, call: str, death: Death) -> Shown:
    """Return how a call ended, with the lines around the place."""
    said = death_messages.message(death, f"{call}()" if call else "")
    sentences = (
        death_messages.told(said, death.location, texts()),
        death_messages.question(said, texts()),
    )
    return _ended(folder, " ".join(filter(None, sentences)), death.location)


def interrupted(folder: Path, call: str, death: Death) -> Shown:
    """Return where the code was when the stop button was pressed."""
    key = "lab.stopped_in" if death.location else "lab.stopped"
    values = {"call": call, "function": death.function, "location": death.location}
    return _ended(folder, texts().say(key, **values), death.location)


def excerpt(folder: Path, location: str) -> Shown | None:
    """Return the lines around a place such as "raytracer.c:41", which is marked."""
    name, _, number = location.partition(":")
    try:
        lines = (folder / name).read_text(encoding="utf-8", errors="replace").splitlines()
        at = int(number)
    except (OSError, ValueError):
        return None
    first, last = max(at - AROUND, 1), min(at + AROUND, len(lines))
    shown = [
        f"{'>' if k == at else ' '} {k:4d} | {lines[k - 1].expandtabs(4)}"
        for k in range(first, last + 1)
    ]
    text = "\n".join(shown)
    place = link(folder / name, at)
    return Shown(f"{place.html}{code(text)}", text)


def printed(session: Session) -> Printed | None:
    """Return what the code has printed since it was last asked, if anything."""
    # The loader's own line has no place in a cell: the card names the function that is missing.
    lines = [each for each in session.printed_since().splitlines() if _LOADER not in each]
    kept = [line[:MAX_COLUMNS] for line in lines[:MAX_LINES]]
    if len(lines) > MAX_LINES:
        kept.append(say("more", count=len(lines) - MAX_LINES))
    text = "\n".join(kept)
    return Printed(code(text), text) if kept else None


def _ended(folder: Path, text: str, location: str) -> Shown:
    around = excerpt(folder, location) if location else None
    inside = stack([_line(text), *([around] if around else [])])
    return card(inside.html, inside.text, "bad")


def _error(folder: Path, error: Diagnostic) -> Shown:
    meaning = error.meaning()
    lines = "\n".join(error.lines)
    shown = [Shown(link(folder / error.file, error.line).html + code(lines), lines)]
    if meaning:
        shown.append(_line(texts().say(meaning.key, **meaning.values)))
    return stack(shown)


def _elsewhere(folder: Path, log: str) -> list[Shown]:
    """Return what the compiler said of no line of the student's, and the #include it came from."""
    lines = "\n".join(log.splitlines()[:MAX_LINES])
    said = [Shown(code(lines), lines)]
    # The last one is the file that was being compiled.
    place = (_INCLUDED_FROM.findall(log) or [""])[-1]
    around = excerpt(folder, place)
    if around is None:
        return said
    return [_line(say("before_include", place=place)), around, *said]


def _line(text: str) -> Shown:
    return Shown(f"<p style='margin:.2em 0'>{escape(text)}</p>", text)
