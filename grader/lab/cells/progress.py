"""progress(): where one stands. help_card(): one screen for whoever comes to help."""

from __future__ import annotations

import difflib
from pathlib import Path
from typing import Any

from grader.course import exercises
from grader.evaluation.records import CheckResult, Outcome
from grader.lab.bridge.engine import Engine, last_engine
from grader.lab.cells.check import JUDGE, SYMBOLS, explained
from grader.lab.cells.source import coloured, find
from grader.lab.display.card import Shown, card, code, escape, stack, table
from grader.lab.display.links import core_folder, graded, link
from grader.lab.display.words import say, texts

MAX_CHANGES = 30  # lines
_BAD = (Outcome.FAILED, Outcome.CRASHED, Outcome.TIMEOUT)


def progress() -> Shown:
    """Return every exercise with what is known of it: this session's checks, or the last grade."""
    rows: list[list[Shown | str]] = []
    last = {each["id"]: each for each in graded().get("exercises", [])}
    for exercise in exercises.load().exercises:
        if not exercise.checks:
            continue
        outcome, points, when = _known(exercise.id, last.get(exercise.id))
        word = f"{SYMBOLS[outcome]} {texts().say(f'outcome.{outcome.value}')}" if outcome else "-"
        most = texts().number(exercise.points / 100)
        bonus = f" {texts().say('report.bonus')}" if exercise.bonus else ""
        rows.append(
            [
                exercise.id,
                exercise.functions[0],
                exercise.titles[texts().language],
                word,
                f"{texts().number(points)} / {most}{bonus}" if outcome else f"- / {most}{bonus}",
                when,
            ]
        )
    heads = [say(f"column.{name}") for name in ("id", "function", "title", "outcome", "points")]
    return table([*heads, say("column.when")], rows)


def help_card() -> Shown:
    """Return what an assistant needs first: what fails, the function, the compiler, the change."""
    engine = last_engine() or Engine(core_folder())
    parts = [_line(say("help_title"))]
    failing = _failing()
    if engine.errors:
        parts.append(Shown(code(engine.errors), engine.errors))
    if failing is None:
        parts.append(_line(say("nothing_fails")))
    else:
        title = f"{failing.exercise} {failing.function} - {failing.title}"
        parts += [_line(title), explained(failing), *_function(failing.function, engine.folder)]
    parts += _changes(engine)
    inside = stack(parts)
    return card(inside.html, inside.text)


def _known(name: str, graded: Any) -> tuple[Outcome | None, float, str]:
    judged = JUDGE.done.get(name)
    if judged is not None:
        return judged.result.outcome, judged.result.points / 100, say("this_session")
    if graded:
        return Outcome(graded["outcome"]), float(graded["points"]), say("last_grade")
    return None, 0.0, ""


def _failing() -> CheckResult | None:
    """Return the last check of this session that failed."""
    for judged in reversed(JUDGE.done.values()):
        for each in judged.checks:
            if each.outcome in _BAD:
                return each
    return None


def _function(name: str, folder: Path) -> list[Shown]:
    found = find(name, folder)
    if found is None:
        return []
    place = link(found.path, found.line)
    return [Shown(place.html + coloured(found.text), f"{place.text}\n{found.text}")]


def _changes(engine: Engine) -> list[Shown]:
    """Return what was changed by the last save that this session has seen."""
    lines: list[str] = []
    for name, now in engine.now.files.items():
        before = engine.before.files.get(name, now)
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
