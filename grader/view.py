"""results.json as lines of text: one per exercise, then what to look at. Reads JSON only."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from grader import manifest
from grader.texts import Texts

Row = Mapping[str, Any]
Line = tuple[str, str]  # text, rich style

MAX_ERRORS = 3  # of one file, shown whole
MAX_WARNINGS = 5
MAX_EXPLAINED = 8  # exercises
MAX_PRINTED, MAX_PRINTED_WIDTH = 5, 100  # lines and columns of what a function printed
BAR_CELLS, SHORT_BAR_CELLS = 10, 5
_EPOCH = "1970-01-01T00:00:00+00:00"
_STYLES = {
    "passed": "green",
    "failed": "yellow",
    "crashed": "red",
    "timeout": "red",
    "error": "magenta",
}  # what is to do, or waits, has none
_TO_EXPLAIN = ("failed", "crashed", "timeout", "error")


@dataclass(frozen=True)
class View:
    """The lines of one report, for a terminal of `width` columns; 0: for a file or a pipe."""

    content: Row
    path: Path
    texts: Texts
    width: int

    def lines(self) -> Iterator[Line]:
        """Yield the report from top to bottom."""
        content, say = self.content, self.texts.say
        yield say("report.graded", name=content["submission"]["name"]), "bold"
        yield from self._sources()
        yield from ((note, "") for note in content["notes"])
        yield from self._build()
        yield from self._table()
        yield from self._details()
        yield "", ""
        yield from self._unjudged()
        yield from self._totals()
        yield from self._next()
        yield say(f"isolation.{content['isolation']}"), "dim"
        yield say("report.saved", path=self.path), "dim"

    def _sources(self) -> Iterator[Line]:
        """Name each graded file with its age, to see whether it is the one that was edited."""
        sources = self.content["submission"]["sources"]
        places = _padded([each["path"] for each in sources])
        for each, place in zip(sources, places, strict=True):
            yield f"  {place}  {self._age(each)}", ""
        times = {each["name"]: each["modified"] for each in sources}
        for each in self.content["submission"]["nearby"]:
            newer = _moment(each) > datetime.fromisoformat(times.get(each["name"], _EPOCH))
            key = "report.newer_copy" if newer else "report.copy"
            age = self._age(each)
            yield self.texts.say(key, path=each["path"], age=age), "yellow" if newer else ""

    def _age(self, source: Row) -> str:
        """Return when a file was last written, counted from the grading."""
        graded = datetime.fromisoformat(self.content["graded_at"])
        seconds = int((graded - _moment(source)).total_seconds())
        for key, unit, below in (
            ("age.now", 1, 60),
            ("age.minutes", 60, 3600),
            ("age.hours", 3600, 2 * 86400),
            ("age.days", 86400, 30 * 86400),
        ):
            if 0 <= seconds < below:
                return self.texts.say(key, count=seconds // unit)
        return self.texts.say("age.date", date=source["modified"][:10])

    def _build(self) -> Iterator[Line]:
        build, say = self.content["build"], self.texts.say
        for name, sentence in build["rejected"].items():
            errors = [each for each in build["errors"] if each["file"] == name]
            yield "", ""
            yield say("report.not_compiled", name=name) if errors else sentence, "yellow"
            yield from self._errors(errors)
        if not build["ok"] and not build["rejected"]:
            yield "", ""
            yield say("report.not_built"), "yellow"
            yield from ((f"  {line}", "") for line in build["log"].splitlines()[:MAX_WARNINGS])
        heads = [each.splitlines()[0] for each in build["warnings"]]
        if heads:
            yield "", ""
            yield say("report.warnings"), ""
            yield from ((f"  {head}", "") for head in heads[:MAX_WARNINGS])
        if len(heads) > MAX_WARNINGS:
            yield "  " + say("report.more", count=len(heads) - MAX_WARNINGS, path=self.path), ""

    def _errors(self, errors: list[Row]) -> Iterator[Line]:
        for each in errors[:MAX_ERRORS]:
            yield from ((f"  {line}", "") for line in each["lines"])
            if each["meaning"]:
                yield f"  {each['meaning']}", ""
        if len(errors) > MAX_ERRORS:
            count = len(errors) - MAX_ERRORS
            yield "  " + self.texts.say("report.more", count=count, path=self.path), ""

    def _table(self) -> Iterator[Line]:
        """Yield a line per exercise; TPs that are closed, or not begun yet, fold into one line."""
        opened = self.content["opened_tps"]
        tps = sorted({each["tp"] for each in self.content["exercises"]})
        closed = [] if self.content["partial"] else [tp for tp in tps if tp not in opened]
        tps = [tp for tp in tps if tp not in closed]
        current = next((tp for tp in tps if not self._is_done(tp)), None)
        folded = []
        for tp in tps:
            rows = self._rows(tp)
            is_later = current is not None and tp > current
            if is_later and not any(each["outcome"] in _STYLES for each in rows):
                folded.append((tp, rows))
            else:
                yield from self._full_tp(tp, rows)
        if folded or closed:
            yield "", ""
        for tp, rows in folded:
            yield from self._folded_tp(tp, rows)
        if closed:
            yield self.texts.say("report.closed", tps=_names(closed)), ""

    def _is_done(self, tp: int) -> bool:
        return all(each["outcome"] == "passed" for each in self._rows(tp) if not each["bonus"])

    def _rows(self, tp: int) -> list[Row]:
        return [each for each in self.content["exercises"] if each["tp"] == tp]

    def _title(self, tp: int) -> str:
        title = manifest.load().tps[tp][self.texts.language]
        return self.texts.say("report.tp", tp=tp, title=title)

    def _folded_tp(self, tp: int, rows: list[Row]) -> Iterator[Line]:
        points = sum(each["max_points"] for each in rows if not each["bonus"])
        number = self.texts.number(points)
        yield self.texts.say("report.later", title=self._title(tp), points=number), ""

    def _full_tp(self, tp: int, rows: list[Row]) -> Iterator[Line]:
        yield "", ""
        yield self._title(tp), "bold"
        columns = [[self.texts.say(f"outcome.{each['outcome']}") for each in rows]]
        columns += [[each[key] for each in rows] for key in ("id", "title", "function")]
        columns = [_padded(column) for column in columns]
        taken = sum(len(column[0]) + 2 for column in columns) + 2
        ends = [self._end(each, BAR_CELLS) for each in rows]
        if self.width and taken + max(map(len, ends)) > self.width:
            ends = [self._end(each, SHORT_BAR_CELLS) for each in rows]
            room = self.width - taken - max(map(len, ends))
            columns[2] = [_cut(title, len(title) + room) for title in columns[2]]
        for each, end, *words in zip(rows, ends, *columns, strict=True):
            yield f"  {'  '.join(words)}  {end}", _STYLES.get(each["outcome"], "")

    def _end(self, exercise: Row, cells: int) -> str:
        points = self._points(exercise["points"], exercise["max_points"])
        bonus = f" {self.texts.say('report.bonus')}" if exercise["bonus"] else ""
        # A screen reader would spell the bar out.
        return f"{_bar(exercise, cells)}  {points}{bonus}" if self.width else f"{points}{bonus}"

    def _points(self, points: float, maximum: float) -> str:
        return f"{self.texts.number(points)} / {self.texts.number(maximum)}"

    def _details(self) -> Iterator[Line]:
        """Tell what is wrong, with a question, of what was tried; then the notes.

        Of a whole run, the first of each exercise: enough to go on with.
        """
        rejected = self.content["build"]["rejected"]
        files = {each["id"]: each["file"] for each in self.content["exercises"]}
        wrong: dict[str, list[Row]] = {}
        for each in self.content["checks"]:
            # The compiler has said all there is to say about a file that it refuses.
            if each["outcome"] in _TO_EXPLAIN and files[each["exercise"]] not in rejected:
                wrong.setdefault(each["exercise"], []).append(each)
        for checks in list(wrong.values())[:MAX_EXPLAINED]:
            yield from self._exercise(checks)
        if len(wrong) > MAX_EXPLAINED:
            yield "", ""
            yield (
                self.texts.say("report.more_exercises", ids=", ".join([*wrong][MAX_EXPLAINED:])),
                "",
            )
        yield from self._notes()

    def _exercise(self, checks: list[Row]) -> Iterator[Line]:
        shown = checks if self.content["partial"] else checks[:1]
        told: set[str] = set()
        for each in shown:
            # A function that crashes does so in each of its checks: the first one says it all.
            if each["outcome"] in told:
                continue
            told |= {each["outcome"]} & {"crashed", "timeout", "error"}
            yield "", ""
            title = f"{each['exercise']} {each['function']} - {each['title']}"
            yield title, _STYLES.get(each["outcome"], "")
            for key in ("message", "hint"):
                yield from ((f"  {line}", "") for line in each[key].splitlines())
            printed = each["output"].splitlines()[:MAX_PRINTED]
            if printed:
                yield f"  {self.texts.say('report.printed')}", ""
                yield from ((f"    {line[:MAX_PRINTED_WIDTH]}", "dim") for line in printed)
        if len(checks) > len(shown):
            keyword = checks[0]["id"].split(".")[1]
            count = len(checks) - len(shown)
            yield "  " + self.texts.say("report.more_checks", count=count, keyword=keyword), ""

    def _notes(self) -> Iterator[Line]:
        """Yield what there is to know besides, the same words once for all their exercises."""
        notes: dict[str, dict[str, None]] = {}
        for each in self.content["checks"]:
            if each["note"]:
                notes.setdefault(each["note"], {})[each["exercise"]] = None
        if notes:
            yield "", ""
        yield from ((f"{', '.join(ids)} - {note}", "") for note, ids in notes.items())

    def _unjudged(self) -> Iterator[Line]:
        tps = self.content["unjudged_tps"]
        if tps:
            key = "report.unjudged" if len(tps) > 1 else "report.unjudged_one"
            yield self.texts.say(key, tps=_names(tps)), ""

    def _totals(self) -> Iterator[Line]:
        content, say = self.content, self.texts.say
        if content["partial"]:
            yield say("report.partial"), ""
        if content["incomplete"]:
            yield say("report.incomplete"), "magenta"
        if not content["checks"]:
            return
        waiting = any(each["outcome"] == "blocked" for each in content["checks"])
        key = "report.total_at_least" if waiting else "report.total"
        yield say(key, points=self._points(content["score"], content["max_score"])), "bold"
        if content["bonus"]:
            points = self._points(content["bonus"], content["max_bonus"])
            yield say("report.bonus_total", points=points), ""

    def _next(self) -> Iterator[Line]:
        content, say = self.content, self.texts.say
        if not content["checks"]:
            return
        if content["build"]["rejected"]:
            names = ", ".join(content["build"]["rejected"])
            yield say("report.compile_first", names=names), ""
            return
        exercises = content["exercises"]
        outcomes = {each["outcome"] for each in exercises}
        if outcomes == {"passed"}:
            yield say("report.done"), "green"
            return
        if outcomes == {"todo"}:
            yield say("report.all_todo"), ""
        if "todo" in outcomes:
            yield say("report.todo_legend"), ""
        ready = [each for each in exercises if each["outcome"] not in ("passed", "blocked")]
        ready.sort(key=lambda each: each["bonus"])
        for exercise in ready[:1]:
            checks = [each for each in content["checks"] if each["exercise"] == exercise["id"]]
            values = {key: exercise[key] for key in ("id", "function", "file")}
            # The middle of a check's id is what K= takes.
            yield say("report.next", keyword=checks[0]["id"].split(".")[1], **values), ""


def _moment(source: Row) -> datetime:
    return datetime.fromisoformat(source["modified"])


def _names(tps: list[int]) -> str:
    return ", ".join(f"TP{tp}" for tp in tps)


def _padded(column: list[str]) -> list[str]:
    width = max(map(len, column), default=0)
    return [word.ljust(width) for word in column]


def _cut(text: str, width: int) -> str:
    """Cut a padded text to a width, at least a word's, telling so when letters are lost."""
    width = min(max(width, 12), len(text))
    kept = text.rstrip()
    return kept.ljust(width) if len(kept) <= width else f"{kept[: width - 1]}…"


def _bar(exercise: Row, cells: int) -> str:
    done = int(cells * exercise["points"] / (exercise["max_points"] or 1))
    return "█" * done + "·" * (cells - done)
