"""The sentences of results.json that the terminal and the page share. Reads JSON only."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime

from grader.course import exercises
from grader.course.texts import Texts
from grader.report.results import Row

Line = tuple[str, str]  # text, rich style
_EPOCH = "1970-01-01T00:00:00+00:00"


@dataclass(frozen=True)
class Summary:
    """What a report says as a whole."""

    content: Row
    texts: Texts

    def age(self, source: Row) -> str:
        """Return when a file was last written, counted from the grading, unless nobody has."""
        if source.get("untouched"):
            return self.texts.say("age.untouched")
        graded = datetime.fromisoformat(self.content["graded_at"])
        seconds = int((graded - _moment(source)).total_seconds())
        return self.texts.age(seconds, source["modified"][:10])

    def when(self, moment: str) -> str:
        """Return a moment as one tells it on the day of the grading: the hour, or the day too."""
        if moment[:10] == self.content["graded_at"][:10]:
            return f"{datetime.fromisoformat(moment):%H:%M}"
        return self.date(moment)

    def date(self, moment: str) -> str:
        """Return a moment with its day."""
        return datetime.fromisoformat(moment).strftime(self.texts.say("history.moment"))

    def nearby(self) -> Iterator[Line]:
        """Name other versions of the files, so that one sees which was judged."""
        times = {each["name"]: each["modified"] for each in self.content["submission"]["sources"]}
        for each in self.content["submission"]["nearby"]:
            newer = _moment(each) > datetime.fromisoformat(times.get(each["name"], _EPOCH))
            key = "report.newer_copy" if newer else "report.copy"
            text = self.texts.say(key, path=each["path"], age=self.age(each))
            yield text, "yellow" if newer else ""

    def not_compiled(self, name: str) -> str:
        """Say that a file does not compile, and whether others are judged all the same."""
        files, rejected = self.content["submission"]["files"], self.content["build"]["rejected"]
        others = any(each.endswith(".c") and each not in rejected for each in files)
        key = "failure.beside_header" if name.endswith(".h") else "failure.beside"
        beside = self.texts.say(key) if others else ""
        return self.texts.say("report.not_compiled", name=name, beside=beside)

    def pointed_out(self) -> tuple[list[str], int]:
        """Return the compiler's warnings that have a meaning, a line each; how many others."""
        build = self.content["build"]
        advice = list(build.get("advice", ()))
        told = {_place(each) for each in advice}
        heads = [each.splitlines()[0] for each in build["warnings"]]
        return advice, sum(_place(each) not in told for each in heads)

    def notes(self) -> Iterator[str]:
        """Yield the notes of the checks, the same words once for all their exercises."""
        notes: dict[str, dict[str, None]] = {}
        for each in self.content["checks"]:
            # What waits says so beside what is seen of it.
            if each["note"] and each["outcome"] != "blocked":
                notes.setdefault(each["note"], {})[each["exercise"]] = None
        yield from (f"{', '.join(ids)} - {note}" for note, ids in notes.items())

    def unjudged(self) -> Iterator[Line]:
        """Say which TPs this version cannot judge."""
        tps = self.content["unjudged_tps"]
        if tps:
            key = "report.unjudged" if len(tps) > 1 else "report.unjudged_one"
            yield self.texts.say(key, tps=", ".join(f"TP{tp}" for tp in tps)), ""

    def points(self, points: float, maximum: float) -> str:
        """Return "2,5 / 4"."""
        return f"{self.texts.number(points)} / {self.texts.number(maximum)}"

    def worth(self, exercise: Row) -> str:
        """Return the points of an exercise; how many of its checks were run when not all were."""
        part = exercise.get("part")
        if part:
            return self.texts.say("report.part", **part)
        bonus = f" {self.texts.say('report.bonus')}" if exercise["bonus"] else ""
        return self.points(exercise["points"], exercise["max_points"]) + bonus

    @property
    def parts(self) -> list[Row]:
        """The exercises of which some checks were not asked for: they have no points to tell."""
        return [each for each in self.content["exercises"] if "part" in each]

    def totals(self) -> Iterator[Line]:
        """Say the total and the bonus, and what keeps them from being a mark."""
        content, say = self.content, self.texts.say
        if content["partial"]:
            yield say("report.partial"), ""
        if content["incomplete"]:
            yield say("report.incomplete"), "magenta"
        for each in self.parts:
            count = each["part"]["of"] - each["part"]["run"]
            yield say("report.part_left", id=each["id"], count=count), ""
        if not content["checks"] or self.parts:
            return
        waiting = any(each["outcome"] == "blocked" for each in content["checks"])
        key = "report.total_at_least" if waiting else "report.total"
        if content["max_score"]:
            yield say(key, points=self.points(content["score"], content["max_score"])), "bold"
        if content["bonus"] or not content["max_score"]:
            points = self.points(content["bonus"], content["max_bonus"])
            yield say("report.bonus_total", points=points), ""

    def changes(self) -> Iterator[Line]:
        """Say what changed since the last full run."""
        say, number = self.texts.say, self.texts.number
        for each in self.content["changes"]:
            values = {"id": each["exercise"]}
            values |= {key: number(each[key]) for key in ("was", "points")}
            values |= {key: self.when(each[key]) for key in ("before", "since") if key in each}
            style = {"fixed": "green", "broken": "yellow"}.get(each["kind"], "")
            yield say(f"history.{each['kind']}", **values), style
        same = self.content["same_files_as"]
        if same and any(each["outcome"] != "passed" for each in self.content["exercises"]):
            yield say("history.same_files", since=self.when(same)), ""

    def state(self, exercise: Row) -> str:
        """Return what became of an exercise; that of a file that does not compile is not known."""
        if exercise["outcome"] == "failed" and self._is_rejected(exercise):
            return "not_compiled"
        return str(exercise["outcome"])

    def _is_rejected(self, exercise: Row) -> bool:
        return exercise["file"] in self.content["build"]["rejected"]

    def praise(self) -> Iterator[Line]:
        """Say a word when a whole TP, or all of them, have just become right."""
        content, say = self.content, self.texts.say
        whole = [each for each in content["tps"] if each["score"] == _worth(each["tp"])]
        if len(whole) == len(exercises.load().tps):
            points = self.points(content["score"], content["max_score"])
            yield say("report.all_done", points=points), "green"
            return
        fixed = {each["exercise"] for each in content["changes"] if each["kind"] == "fixed"}
        tps = {each["tp"] for each in content["exercises"] if each["id"] in fixed}
        is_first = content["partial"] or len(content["history"]) < 2
        for each in whole:
            if is_first or each["tp"] in tps:
                points = self.points(each["score"], each["max_score"])
                yield say("report.tp_done", tp=each["tp"], points=points), "green"

    def by_tp(self) -> Iterator[Line]:
        """Say the points of each TP in one line, where there are several."""
        rows = self.content["tps"]
        if len(rows) > 1 and self.content["score"]:
            told = [
                f"TP{each['tp']} {self.points(each['score'], each['max_score'])}" for each in rows
            ]
            yield self.texts.say("report.by_tp", points=", ".join(told)), ""

    def next_exercise(self) -> Row | None:
        """Return the first exercise to work on: what is wrong, then what is to do; bonuses last."""
        ready = [
            each
            for each in self.content["exercises"]
            if each["outcome"] not in ("passed", "blocked")
        ]
        return min(
            ready, key=lambda each: (each["outcome"] == "todo", bool(each["bonus"])), default=None
        )

    def next_step(self) -> Iterator[Line]:
        """Say what to do now."""
        content, say = self.content, self.texts.say
        if not content["checks"]:
            return
        if content["build"]["rejected"]:
            names = ", ".join(content["build"]["rejected"])
            yield say("report.compile_first", names=names), ""
            return
        outcomes = {each["outcome"] for each in content["exercises"]}
        if outcomes == {"passed"}:
            yield from self._after()
            return
        if outcomes == {"todo"}:
            yield say("report.all_todo"), ""
        if "todo" in outcomes:
            yield say("report.todo_legend"), ""
        exercise = self.next_exercise()
        if exercise:
            # Of several functions, the first that is not right.
            check = next(
                each
                for each in content["checks"]
                if each["exercise"] == exercise["id"] and each["outcome"] != "passed"
            )
            yield self._next(exercise["id"], check["function"], exercise["file"], check["id"])
        elif waited := [name for each in content["checks"] for name in each["waits_for"]]:
            # All that is left waits for what was not asked for.
            first = exercises.load().exercise(waited[0])
            yield self._next(first.id, first.functions[0], first.file, first.checks[0].id)

    def _next(self, name: str, function: str, file: str, check: str) -> Line:
        # The middle of a check's id is what K= takes, where a function has two exercises.
        keyword = exercises.subject(check)
        values = {"id": name, "function": function, "file": file, "keyword": keyword}
        return self.texts.say("report.next", **values), "bold"

    def _after(self) -> Iterator[Line]:
        """Say what comes after exercises that are all right: those of this run, or of them all."""
        yield self.texts.say("report.done"), "green"
        found = self.content.get("earlier", {}).items()
        right = {name for name, outcome in found if outcome == "passed"}
        right |= {each["id"] for each in self.content["exercises"]}
        opened = self.content["opened_tps"]
        left = [
            each
            for each in exercises.load().exercises
            if each.checks and each.tp in opened and each.id not in right
        ]
        if not self.content["partial"]:
            return
        if not left:
            yield self.texts.say("report.grade_all"), ""
            return
        # Onwards from here; what was left behind, and bonuses, come last.
        done = max(_order(each["id"]) for each in self.content["exercises"])
        then = min(left, key=lambda each: (each.bonus, _order(each.id) < done, _order(each.id)))
        yield self._next(then.id, then.functions[0], then.file, then.checks[0].id)


def _order(name: str) -> int:
    return [each.id for each in exercises.load().exercises].index(name)


def _worth(tp: int) -> float:
    """Return the points of a whole TP, without its bonuses."""
    own = [each for each in exercises.load().exercises if each.tp == tp and not each.bonus]
    return sum(each.points for each in own if each.checks) / 100


def _place(line: str) -> tuple[str, ...]:
    """Return the file and the line with which a line of the compiler's, or on it, begins."""
    return tuple(each.strip() for each in line.split(":")[:2])


def _moment(source: Row) -> datetime:
    return datetime.fromisoformat(source["modified"])
