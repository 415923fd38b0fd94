"""build/oral/NAME.html: the questions for the student, then their answers for the assistant.

One page that needs nothing else; what the submission wrote is shown and never acts.
"""

from __future__ import annotations

import base64
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from grader.authoring.oral.records import Change, Question, Sight, Swapped, Traced
from grader.checking.pictures import views
from grader.checking.pictures.measure import Floats, worst_tile
from grader.course import exercises
from grader.course.texts import Texts
from grader.intake.records import Submission
from grader.report import page

TEMPLATES = Path(__file__).parent / "templates"
LEVELS = 255
AROUND = 2  # lines shown before and after those that change


@dataclass(frozen=True)
class Excerpt:
    """Lines of a file, the first of which has the number `first`; `marked` are asked about."""

    text: str
    first: int
    marked: tuple[int, int] = (0, -1)


def render(submission: Submission, questions: Sequence[Question], level: str, texts: Texts) -> str:
    """Return the page; `level` is the isolation in which the submission ran."""
    made = page.environment(texts, TEMPLATES, "oral.css")
    return made.get_template("oral.html").render(
        name=submission.name,
        level=level,
        asked=[_asked(each, submission, texts) for each in questions],
        lines=sum(isinstance(each, Swapped) for each in questions),
        values=sum(isinstance(each, Traced) for each in questions),
        twin=texts.say("failure.twin"),
        hundredths=lambda points: texts.number(points / 100),
    )


def _asked(question: Question, submission: Submission, texts: Texts) -> dict[str, Any]:
    """Return what the templates show of a question."""
    if isinstance(question, Traced):
        place = question.place
        excerpt = Excerpt(place.text, place.line)
        shown = {"kind": "values", "sentence": texts.say("oral.ask_values")}
        exercise = question.exercise
    else:
        change, place = question.change, question.change.place
        excerpt, exercise = _excerpt(change, submission), change.mistake.exercise
        shown = {
            "kind": "line",
            "lead": _lead(change, texts),
            "sentence": _sentence(question, texts),
            "old": textwrap.dedent(place.text.expandtabs()),
            "new": textwrap.dedent(change.new.expandtabs()),
            **_seen(question, texts),
        }
    title = texts.title(exercises.load().exercise(exercise))
    return {
        **shown,
        "question": question,
        "excerpt": excerpt,
        "place": place,
        "exercise": exercise,
        "title": title,
    }


def _excerpt(change: Change, submission: Submission) -> Excerpt:
    """Return the lines that change, as they stand, with a few around them."""
    place = change.place
    text = submission.files[place.file].decode("utf-8", "surrogateescape")
    lines = text.split("\n")
    last = place.line + place.text.count("\n")
    first = max(place.line - AROUND, 1)
    return Excerpt("\n".join(lines[first - 1 : last + AROUND]), first, (place.line, last))


def _lead(change: Change, texts: Texts) -> str:
    """Return how a question on changed lines begins."""
    several = "\n" in change.place.text
    if change.new:
        return texts.say("oral.become_lines" if several else "oral.become")
    return texts.say("oral.removed_lines" if several else "oral.removed")


def _sentence(question: Swapped, texts: Texts) -> str:
    """Return the question on a changed line."""
    sight = question.sight
    if sight is None:
        return texts.say("oral.ask_result", function=question.change.place.function)
    if sight.scene is None:
        return texts.say("oral.ask_call")
    return texts.say("oral.ask_scene", scene=sight.scene)


def _seen(question: Swapped, texts: Texts) -> dict[str, Any]:
    """Return the pictures of a change as URIs, by role, and what the change does to them."""
    sight = question.sight
    if sight is None:
        return {"call": "", "images": {}, "effect": ""}
    return {"call": sight.call, "images": _images(sight), "effect": _effect(sight, texts)}


def _images(sight: Sight) -> dict[str, str]:
    after = sight.after.picture
    got = sight.before if after is None else after
    apart: Floats = np.abs(got - sight.before).max(axis=2).astype(np.float32)
    _, worst = worst_tile(np.rint(apart * LEVELS).astype(np.int32))
    drawn = views.images(got, sight.before, apart, worst)
    roles = {"before": "expected"}
    if after is not None:
        roles |= {"after": "got", "difference": "difference"}
    return {
        role: f"data:image/png;base64,{base64.b64encode(drawn[name]).decode()}"
        for role, name in roles.items()
    }


def _effect(sight: Sight, texts: Texts) -> str:
    if sight.after.death:
        return texts.say("oral.dies", how=sight.after.death)
    if not sight.changed:
        return texts.say("oral.unseen")
    total = sight.before.shape[0] * sight.before.shape[1]
    return texts.say("oral.changed", count=round(sight.changed * total), total=total)
