"""results.json in the lines that Moodle VPL reads of an evaluation. Reads JSON only.

VPL takes lines that begin with `Comment :=>>`, those of them whose text begins with a hyphen as
titles, and the last one that begins with `Grade :=>>`. Texts may hold what a submission has
printed, so each of their lines is made a comment, and the grade comes last.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from grader.course.texts import Texts
from grader.report.gradescope import told_of, wrong_checks
from grader.report.results import Row
from grader.report.summary import Summary

COMMENT, GRADE = "Comment :=>>", "Grade :=>>"
_ENDS = re.compile(r"[\r\n\v\f\x1c-\x1e\x85\u2028\u2029]+")


def as_vpl(content: Row, most: float) -> list[str]:
    """Return the lines of a grade out of `most`; bonuses count, up to it."""
    texts = Texts(content["language"])
    lines = [each for line, _ in Summary(content, texts).totals() for each in comments(line)]
    for exercise in content["exercises"]:
        lines += _told(exercise, content, texts)
    points = (content["score"] + content["bonus"]) / content["max_score"] * most
    return [*lines, _grade(min(max(points, 0.0), most))]


def nothing(reason: str) -> list[str]:
    """Return the lines of a submission in which nothing can be judged."""
    return [*comments(reason), _grade(0.0)]


def comments(text: str, before: str = "") -> list[str]:
    """Return a text as comments, one for each of its lines."""
    return [
        f"{COMMENT}{before} {_visible(line)}".rstrip() for line in _ENDS.split(text) if line.strip()
    ]


def _told(exercise: Row, content: Row, texts: Texts) -> Iterator[str]:
    """Yield the title of an exercise, with its points, then what is wrong in it."""
    points = f"{texts.number(exercise['points'])} / {texts.number(exercise['max_points'])}"
    title = f"{exercise['id']} {exercise['function']} - {exercise['title']} ({points})"
    yield from comments(title, before="-")
    for check in wrong_checks(exercise, content):
        for each in told_of(check):
            yield from comments(each)


def _visible(line: str) -> str:
    """Return a line without controls, that begins like no title and no preformatted text."""
    text = "".join(each if each.isprintable() else " " for each in line).strip()
    return f" {text}" if text[:1] in ("-", ">", "<") else text


def _grade(value: float) -> str:
    return f"{GRADE} {value:.2f}"
