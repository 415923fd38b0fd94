"""results.json in a few lines: what was judged, and the first thing wrong of each exercise."""

from __future__ import annotations

from collections.abc import Iterator

from grader.course.texts import Texts
from grader.report.results import Row
from grader.report.summary import Line, Summary
from grader.report.text import STYLES, TO_EXPLAIN


def lines(content: Row, texts: Texts) -> Iterator[Line]:
    """Yield a line per exercise, below it a sentence and a question where something is wrong.

    Nothing when a file does not compile, since the whole report shows the compiler's own lines.
    """
    if not content["build"]["ok"]:
        return
    names = dict.fromkeys(each["function"] for each in content["exercises"])
    yield texts.say("watch.changed", names=", ".join(names)), "bold"
    for each in content["exercises"]:
        state = Summary(content, texts).state(each)
        words = (texts.say(f"outcome.{state}"), each["id"], each["title"], each["function"])
        yield "  ".join(words), STYLES.get(state, "")
        yield from ((f"  {line}", "") for line in _first_wrong(content, each))
    yield "", ""


def _first_wrong(content: Row, exercise: Row) -> list[str]:
    for each in content["checks"]:
        if each["exercise"] == exercise["id"] and each["outcome"] in TO_EXPLAIN:
            return [*each["message"].splitlines(), *each["hint"].splitlines()]
    return []
