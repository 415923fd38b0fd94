"""progress(): where one stands. help_card(): one screen for whoever comes to help."""

from __future__ import annotations

import contextlib
import difflib
from collections.abc import Sequence
from pathlib import Path

from grader.course import exercises
from grader.evaluation.records import CheckResult
from grader.evaluation.rules import DONE_WRONG
from grader.lab.bridge.engine import Engine, last_engine
from grader.lab.bridge.saves import SAVES
from grader.lab.cells import album, record
from grader.lab.cells.check import SYMBOLS, explained, next_step, word
from grader.lab.cells.judge import JUDGE
from grader.lab.cells.source import coloured, find
from grader.lab.display.card import Shown, card, code, escape, stack, table
from grader.lab.display.links import core_folder, link
from grader.lab.display.stopped import Stopped
from grader.lab.display.words import say, texts

MAX_CHANGES = 30  # lines


def progress() -> Shown:
    """Return every exercise with what is known of it, the points of each TP, and the next step.

    And the pictures that the code drew on the way.
    """
    found = record.known()
    heads = [say(f"column.{name}") for name in ("id", "function", "title", "outcome", "points")]
    rows = table([*heads, say("column.when")], [_row(each) for each in found])
    pictures = album.strip()
    own = [pictures] if pictures else []
    return stack([rows, _line(_by_tp(found)), *own, *next_step(record.following(found))])


def _row(known: record.Known) -> list[Shown | str]:
    exercise, outcome = known.exercise, known.outcome
    told = f"{SYMBOLS[outcome]} {word(outcome, known.points)}" if outcome else "-"
    points = texts().number(known.points) if outcome else "-"
    bonus = f" {texts().say('report.bonus')}" if exercise.bonus else ""
    return [
        exercise.id,
        exercise.functions[0],
        texts().title(exercise),
        told,
        f"{points} / {texts().number(exercise.points / 100)}{bonus}",
        say(known.when) if known.when else "",
    ]


def _by_tp(rows: Sequence[record.Known]) -> str:
    """Return the points of each TP, without its bonuses."""
    told, number = [], texts().number
    for tp in exercises.load().tps:
        own = [each for each in rows if each.exercise.tp == tp and not each.exercise.bonus]
        most = sum(each.exercise.points for each in own) / 100
        told.append(f"TP{tp} {number(sum(each.points for each in own))} / {number(most)}")
    return texts().say("report.by_tp", points=", ".join(told))


def help_card() -> Shown:
    """Return what an assistant needs first: what fails, the function, the compiler, the change."""
    engine = last_engine() or Engine(core_folder())
    with contextlib.suppress(Stopped):  # files that cannot be read: those of before
        engine.refresh()
    parts = [_line(say("help_title"))]
    failing = _failing()
    if engine.errors:
        parts.append(Shown(code(engine.errors), engine.errors))
    if failing is None:
        parts.append(_line(say("nothing_fails")))
    else:
        title = f"{failing.exercise} {failing.function} - {failing.title}"
        parts += [_line(title), explained(failing), *_function(failing.function, engine.folder)]
    parts += _changes(engine.folder)
    inside = stack(parts)
    return card(inside.html, inside.text)


def _failing() -> CheckResult | None:
    """Return the last check of this session that failed."""
    for judged in reversed(JUDGE.done.values()):
        for each in judged.checks:
            if each.outcome in DONE_WRONG:
                return each
    return None


def _function(name: str, folder: Path) -> list[Shown]:
    found = find(name, folder)
    if found is None:
        return []
    place = link(folder / found.file, found.line)
    return [Shown(place.html + coloured(found.text), f"{place.text}\n{found.text}")]


def _changes(folder: Path) -> list[Shown]:
    """Return what was changed by the last save that this session has seen."""
    lines: list[str] = []
    before_all, now_all = SAVES.last(folder)
    for name, now in now_all.items():
        before = before_all.get(name, now)
        lines += difflib.unified_diff(
            before.decode(errors="replace").splitlines(),
            now.decode(errors="replace").splitlines(),
            name,
            name,
            n=1,
            lineterm="",
        )
    if not lines:
        return []
    text = "\n".join(lines[:MAX_CHANGES])
    return [_line(say("last_change")), Shown(code(text), text)]


def _line(text: str) -> Shown:
    return Shown(f"<p><b>{escape(text)}</b></p>", text)
