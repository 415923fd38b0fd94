"""results.json in the form that Gradescope documents for an autograder. Reads JSON and pictures.

A test for each exercise, with what is wrong in it and the pictures of what was expected and drawn.
The names of the fields are those of Gradescope's page on autograder specifications.
"""

from __future__ import annotations

import base64
import html
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from grader.course.texts import Texts
from grader.report.results import Row
from grader.report.summary import Summary

MAX_SHOWN = 2  # failing checks of an exercise
MAX_PICTURES = 12  # of a report, which is kept for each submission
_WRONG = ("failed", "crashed", "timeout", "error", "blocked")
_SHOWN = ("expected", "got")


def as_gradescope(content: Row, folder: Path) -> dict[str, Any]:
    """Return the content of Gradescope's results.json; pictures lie beside ours, in `folder`."""
    texts = Texts(content["language"])
    pictures = _Pictures(folder)
    lines = [line for line, _ in Summary(content, texts).totals()]
    return {
        **nothing("\n".join([*lines, *content["notes"]])),
        "score": content["score"] + content["bonus"],
        "execution_time": round(sum(each["seconds"] for each in content["checks"])),
        "tests": [_test(each, content, pictures, texts) for each in content["exercises"]],
    }


def nothing(reason: str) -> dict[str, Any]:
    """Return what is given to a submission in which nothing can be judged."""
    return {
        "score": 0,
        "output": reason,
        "output_format": "text",
        "visibility": "visible",
        "stdout_visibility": "hidden",
        "tests": [],
    }


def wrong_checks(exercise: Row, content: Row) -> list[Row]:
    """Return the first checks of an exercise that are not right."""
    own = [each for each in content["checks"] if each["exercise"] == exercise["id"]]
    return [each for each in own if each["outcome"] in _WRONG][:MAX_SHOWN]


def told_of(check: Row) -> list[str]:
    """Return the sentences of a check that is not right."""
    told = (*(check[key] for key in ("title", "message", "note", "hint")), check.get("places"))
    return [each for each in told if each]


class _Pictures:
    """Pictures as part of a page, as many as one report may have."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._left = folder, MAX_PICTURES

    def shown(self, images: Row) -> Iterator[str]:
        """Yield the pictures of a check."""
        for role in _SHOWN:
            path = self._folder / images.get(role, "")
            if self._left and images.get(role) and path.is_file():
                self._left -= 1
                data = base64.b64encode(path.read_bytes()).decode()
                yield f'<img alt="{role}" src="data:image/png;base64,{data}">'


def _test(exercise: Row, content: Row, pictures: _Pictures, texts: Texts) -> dict[str, Any]:
    parts = [html.escape(texts.say(f"outcome.{exercise['outcome']}"))]
    for check in wrong_checks(exercise, content):
        parts += [html.escape(each).replace("\n", "<br>") for each in told_of(check)]
        parts.append(" ".join(pictures.shown(check["images"])))
    return {
        "name": f"{exercise['id']} {exercise['function']} - {exercise['title']}",
        "score": exercise["points"],
        "max_score": exercise["max_points"],
        "status": "passed" if exercise["outcome"] == "passed" else "failed",
        "output": "".join(f"<p>{each}</p>" for each in parts if each),
        "output_format": "html",
        "visibility": "visible",
    }
