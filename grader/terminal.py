"""results.json as text: one line per exercise, then what to look at. Reads JSON only.

On a terminal, rich colours the lines; piped, the same lines come plain. What is not written yet is
calm: colour is for what was tried.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, TextIO

from rich.console import Console
from rich.text import Text

from grader import manifest
from grader.texts import Texts

Row = Mapping[str, Any]
Line = tuple[str, str]  # text, rich style

MAX_LOG_LINES = 30
MAX_WARNINGS = 5
BAR_CELLS = 10
_STYLES = {
    "passed": "green",
    "failed": "yellow",
    "crashed": "red",
    "timeout": "red",
    "error": "magenta",
    "blocked": "",
    "todo": "",
}
_TO_EXPLAIN = ("failed", "crashed", "timeout", "error")


def show(content: Row, path: Path, texts: Texts, out: TextIO | None = None) -> None:
    """Print the content of results.json; `path` is where it is, to be named."""
    out = out or sys.stdout
    console = Console(file=out, highlight=False, soft_wrap=True)
    for line, style in _lines(content, path, texts):
        text = _printable(line)
        if console.is_terminal:
            console.print(Text(text, style=style))
        else:
            out.write(f"{text}\n")


def _printable(line: str) -> str:
    """Return the line without the control characters that a submission may have put in it."""
    return "".join(each if each.isprintable() else "�" for each in line.expandtabs()).rstrip()


def _lines(content: Row, path: Path, texts: Texts) -> Iterator[Line]:
    yield texts.say("report.graded", name=content["submission"]["name"]), "bold"
    yield from ((note, "") for note in content["notes"])
    yield from _build(content["build"], path, texts)
    for tp in sorted({each["tp"] for each in content["exercises"]}):
        yield from _tp(content, tp, texts)
    # Nothing can be said of files that do not compile but what the compiler has said.
    if content["build"]["ok"]:
        yield from _details(content["checks"], texts)
    yield "", ""
    yield from _unjudged(content["unjudged_tps"], texts)
    yield from _totals(content, texts)
    yield from _next(content, texts)
    yield texts.say("report.isolation"), "dim"
    yield texts.say("report.saved", path=path), "dim"


def _build(build: Row, path: Path, texts: Texts) -> Iterator[Line]:
    if not build["ok"]:
        lines = build["log"].rstrip().splitlines()
        yield "", ""
        yield texts.say("report.not_built"), "bold"
        yield from ((f"  {line}", "") for line in lines[:MAX_LOG_LINES])
        if len(lines) > MAX_LOG_LINES:
            yield texts.say("report.more_lines", count=len(lines) - MAX_LOG_LINES, path=path), ""
    warnings = [line for line in build["warnings"] if "warning:" in line]
    if warnings:
        yield "", ""
        yield texts.say("report.warnings"), ""
        yield from ((f"  {line}", "") for line in warnings[:MAX_WARNINGS])


def _tp(content: Row, tp: int, texts: Texts) -> Iterator[Line]:
    rows = [each for each in content["exercises"] if each["tp"] == tp]
    yield "", ""
    yield texts.say("report.tp", tp=tp, title=manifest.load().tps[tp][texts.language]), "bold"
    columns = [[texts.say(f"outcome.{each['outcome']}") for each in rows]]
    columns += [[each[key] for each in rows] for key in ("id", "title", "function")]
    columns = [_padded(column) for column in columns]
    for each, *words in zip(rows, *columns, strict=True):
        points = _points(each["points"], each["max_points"], texts)
        bonus = f" {texts.say('report.bonus')}" if each["bonus"] else ""
        yield f"  {'  '.join(words)}  {_bar(each)}  {points}{bonus}", _STYLES[each["outcome"]]


def _padded(column: list[str]) -> list[str]:
    width = max(len(word) for word in column)
    return [word.ljust(width) for word in column]


def _bar(exercise: Row) -> str:
    done = int(BAR_CELLS * exercise["points"] / (exercise["max_points"] or 1))
    return "█" * done + "·" * (BAR_CELLS - done)


def _points(points: float, maximum: float, texts: Texts) -> str:
    return f"{texts.number(points)} / {texts.number(maximum)}"


def _details(checks: list[Row], texts: Texts) -> Iterator[Line]:
    """Tell what is wrong, with a question, of everything that was tried; then the notes."""
    told = set()
    for each in checks:
        # A function that crashes does so in each of its checks: the first one says it all.
        key = (each["exercise"], each["outcome"])
        if each["outcome"] in _TO_EXPLAIN and key not in told:
            told |= {key} & {(each["exercise"], name) for name in ("crashed", "timeout")}
            yield "", ""
            yield (
                f"{each['exercise']} {each['function']} - {each['title']}",
                _STYLES[each["outcome"]],
            )
            yield from ((f"  {each[key]}", "") for key in ("message", "hint") if each[key])
    # Checks of one exercise have the same note: once is enough.
    notes = {f"{each['exercise']} - {each['note']}": None for each in checks if each["note"]}
    if notes:
        yield "", ""
        yield from ((note, "") for note in notes)


def _unjudged(tps: list[int], texts: Texts) -> Iterator[Line]:
    if tps:
        names = ", ".join(f"TP{tp}" for tp in tps)
        yield texts.say("report.unjudged" if len(tps) > 1 else "report.unjudged_one", tps=names), ""


def _totals(content: Row, texts: Texts) -> Iterator[Line]:
    if content["partial"]:
        yield texts.say("report.partial"), ""
    if content["incomplete"]:
        yield texts.say("report.incomplete"), "magenta"
    if not content["checks"]:
        return
    points, maximum = texts.number(content["score"]), texts.number(content["max_score"])
    yield texts.say("report.total", points=points, max=maximum), "bold"
    if content["max_bonus"]:
        points, maximum = texts.number(content["bonus"]), texts.number(content["max_bonus"])
        yield texts.say("report.bonus_total", points=points, max=maximum), ""


def _next(content: Row, texts: Texts) -> Iterator[Line]:
    if not content["checks"] or not content["build"]["ok"]:
        return
    outcomes = {each["outcome"] for each in content["exercises"]}
    if outcomes == {"passed"}:
        yield texts.say("report.done"), "green"
        return
    if outcomes == {"todo"}:
        yield texts.say("report.all_todo"), ""
    if "todo" in outcomes:
        yield texts.say("report.todo_legend"), ""
    ready = [each for each in content["exercises"] if each["outcome"] not in ("passed", "blocked")]
    for exercise in ready[:1]:
        checks = [each for each in content["checks"] if each["exercise"] == exercise["id"]]
        values = {key: exercise[key] for key in ("id", "function", "file")}
        # The middle of a check's id is what K= takes.
        yield texts.say("report.next", keyword=checks[0]["id"].split(".")[1], **values), ""
