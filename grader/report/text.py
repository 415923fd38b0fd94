"""results.json as lines of text: one per exercise, then what to look at. Reads JSON only."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from grader.course import exercises
from grader.course.texts import Texts
from grader.report.results import Row
from grader.report.summary import Line, Summary

MAX_ERRORS = 3  # of one file, shown whole
MAX_WARNINGS = 8
MAX_EXPLAINED = 8  # exercises
MAX_WAITING = 3
MAX_PRINTED, MAX_PRINTED_WIDTH = 5, 100  # lines and columns of what a function printed
BAR_CELLS, SHORT_BAR_CELLS = 10, 5
MAX_CUT = 8  # letters of a title, before the functions give way
STYLES = {
    "passed": "green",
    "failed": "yellow",
    "crashed": "red",
    "timeout": "red",
    "error": "magenta",
}  # what is to do, or waits, has none
STRONG = "strong"  # the isolation of which nothing need be said
TO_EXPLAIN = ("failed", "crashed", "timeout", "error")


@dataclass(frozen=True)
class View:
    """The lines of one report, for a terminal of `width` columns; 0: for a file or a pipe."""

    content: Row
    path: Path
    texts: Texts
    width: int

    @property
    def summary(self) -> Summary:
        """The sentences on the report as a whole."""
        return Summary(self.content, self.texts)

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
        yield from self.summary.unjudged()
        yield from self.summary.totals()
        yield from self.summary.by_tp()
        yield from self.summary.changes()
        yield from self.summary.praise()
        yield "", ""
        yield from self.summary.next_step()
        if content["isolation"] != STRONG:
            yield say(f"isolation.{content['isolation']}"), "dim"
        yield say("report.saved", path=self.path), "dim"

    def _sources(self) -> Iterator[Line]:
        """Name each graded file with its age, to see whether it is the one that was edited."""
        sources = self.content["submission"]["sources"]
        places = _padded([each["path"] for each in sources])
        for each, place in zip(sources, places, strict=True):
            yield f"  {place}  {self.summary.age(each)}", ""
        yield from self.summary.nearby()

    def _build(self) -> Iterator[Line]:
        build, say = self.content["build"], self.texts.say
        for name, sentence in build["rejected"].items():
            errors = [each for each in build["errors"] if each["file"] == name]
            yield "", ""
            yield self.summary.not_compiled(name) if errors else sentence, "yellow"
            yield from self._errors(errors)
        if not build["ok"] and not build["rejected"]:
            yield "", ""
            yield say("report.not_built"), "yellow"
            yield from ((f"  {line}", "") for line in build["log"].splitlines()[:MAX_WARNINGS])
        yield from self._warnings()

    def _warnings(self) -> Iterator[Line]:
        """Yield the warnings that are an answer; the others are on the page, in their own words."""
        pointed, others = self.summary.pointed_out()
        if pointed or others:
            yield "", ""
        if pointed:
            yield self.texts.say("report.warnings"), ""
            yield from ((f"  {line}", "") for line in pointed[:MAX_WARNINGS])
        for key, count in (
            ("report.more", len(pointed) - MAX_WARNINGS),
            ("report.other_warnings" if pointed else "report.minor_warnings", others),
        ):
            if count > 0:
                margin = "  " if pointed else ""
                yield margin + self.texts.say(key, count=count, path=self.path), ""

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
        known = exercises.load().tps
        closed = [] if self.content["partial"] else [tp for tp in known if tp not in opened]
        tps = [tp for tp in tps if tp not in closed]
        current = next((tp for tp in tps if not self._is_done(tp)), None)
        folded = []
        for tp in tps:
            rows = self._rows(tp)
            is_later = current is not None and tp > current
            if is_later and not any(self.summary.state(each) in STYLES for each in rows):
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
        return self.texts.say("report.tp", tp=tp, title=self.texts.tp_title(tp))

    def _folded_tp(self, tp: int, rows: list[Row]) -> Iterator[Line]:
        points = sum(each["max_points"] for each in rows if not each["bonus"])
        number = self.texts.number(points)
        yield self.texts.say("report.later", title=self._title(tp), points=number), ""

    def _full_tp(self, tp: int, rows: list[Row]) -> Iterator[Line]:
        yield "", ""
        yield self._title(tp), "bold"
        states = [self.summary.state(each) for each in rows]
        columns = [[self.texts.say(f"outcome.{state}") for state in states]]
        columns += [[each[key] for each in rows] for key in ("id", "title", "function")]
        columns = [_padded(column) for column in columns]
        columns, ends = self._fitted(columns, rows)
        for state, end, *words in zip(states, ends, *columns, strict=True):
            yield f"  {'  '.join(words)}  {end}", STYLES.get(state, "")

    def _fitted(
        self, columns: list[list[str]], rows: list[Row]
    ) -> tuple[list[list[str]], list[str]]:
        """Fit a table into the width: at the cost of its bars, then functions, then titles."""
        outcomes, ids, titles, functions = columns
        for cells in (BAR_CELLS, SHORT_BAR_CELLS, 0):
            ends = [self._end(each, cells) for each in rows]
            room = self.width - 2 - sum(len(each[0]) + 2 for each in columns) - max(map(len, ends))
            if not self.width or room >= 0:
                return columns, ends
        kept = [functions]
        if room < -MAX_CUT:
            room += len(functions[0]) + 2
            kept = []
        return [outcomes, ids, [_cut(each, len(each) + room) for each in titles], *kept], ends

    def _end(self, exercise: Row, cells: int) -> str:
        # A screen reader would spell the bar out.
        is_drawn = self.width and cells and "part" not in exercise
        bar = f"{_bar(exercise, cells)}  " if is_drawn else ""
        return f"{bar}{self.summary.worth(exercise)}"

    def _details(self) -> Iterator[Line]:
        """Tell what is wrong, with a question, of what was tried; then the notes.

        Of a whole run, the first of each exercise: enough to go on with.
        """
        rejected = self.content["build"]["rejected"]
        files = {each["id"]: each["file"] for each in self.content["exercises"]}
        wrong: dict[str, list[Row]] = {}
        for each in self.content["checks"]:
            # The compiler has said all there is to say about a file that it refuses.
            if each["outcome"] in TO_EXPLAIN and files[each["exercise"]] not in rejected:
                wrong.setdefault(each["exercise"], []).append(each)
        for checks in list(wrong.values())[:MAX_EXPLAINED]:
            yield from self._exercise(checks)
        if len(wrong) > MAX_EXPLAINED:
            yield "", ""
            yield (
                self.texts.say("report.more_exercises", ids=", ".join([*wrong][MAX_EXPLAINED:])),
                "",
            )
        yield from self._waiting()
        yield from self._notes()

    def _waiting(self) -> Iterator[Line]:
        """Show what is seen of the first check of each exercise that waits: calm, no question."""
        seen: dict[str, Row] = {}
        for each in self.content["checks"]:
            if each["waits_for"]:
                seen.setdefault(each["exercise"], each)
        for each in list(seen.values())[:MAX_WAITING]:
            yield "", ""
            yield f"{each['exercise']} {each['function']} - {each['title']}", "dim"
            for key in ("note", "message"):
                yield from ((f"  {line}", "dim") for line in each[key].splitlines())
        if len(seen) > MAX_WAITING:
            ids = ", ".join([*seen][MAX_WAITING:])
            yield "", ""
            yield self.texts.say("report.more_waiting", ids=ids), "dim"

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
            yield title, STYLES.get(each["outcome"], "")
            for key in ("message", "hint"):
                yield from ((f"  {line}", "") for line in each[key].splitlines())
            printed = each["output"].splitlines()[:MAX_PRINTED]
            if printed:
                yield f"  {self.texts.say('report.printed')}", ""
                yield from ((f"    {line[:MAX_PRINTED_WIDTH]}", "dim") for line in printed)
        yield from self._more_help(shown)
        pixels = [each["pixel"] for each in checks if "pixel" in each]
        yield from ((f"  {pixel['told']}", "") for pixel in pixels[:1])
        if len(checks) > len(shown):
            keyword = exercises.subject(checks[0]["id"])
            count = len(checks) - len(shown)
            yield "  " + self.texts.say("report.more_checks", count=count, keyword=keyword), ""

    def _more_help(self, checks: list[Row]) -> Iterator[Line]:
        """Say how to ask for the next hint, and how to make the call again, where one can."""
        say, name = self.texts.say, checks[0]["exercise"]
        levels = [each["hints"][0]["level"] for each in checks if "hints" in each]
        if levels:
            yield "  " + say("report.more_help", id=name, level=min(levels)), "dim"
        places = {Path(each["path"]).parent for each in self.content["submission"]["sources"]}
        if any(each["reproducer"] for each in checks) and places == {Path(exercises.CORE.name)}:
            yield "  " + say("report.again", id=name), "dim"

    def _notes(self) -> Iterator[Line]:
        """Yield what there is to know besides, the same words once for all their exercises."""
        notes = list(self.summary.notes())
        if notes:
            yield "", ""
        yield from ((note, "") for note in notes)


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
