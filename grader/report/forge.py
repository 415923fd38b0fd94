"""What a forge shows of a grade: GitHub's job summary and Classroom's points. Reads JSON only.

    python -m grader.report.forge RESULTS.json

Writes to the files that GitHub Actions names in GITHUB_STEP_SUMMARY and GITHUB_OUTPUT (`result`);
elsewhere, as in a runner of one's own, prints both.
"""

from __future__ import annotations

import base64
import json
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from grader.console.run import ExitCode, complain
from grader.course.texts import Texts
from grader.report import at_lines
from grader.report.at_lines import Annotation
from grader.report.results import Row
from grader.report.summary import Summary

VERSION = 1  # of the format that Classroom's reporter reads
_CELL = str.maketrans({"|": "\\|", "\n": " ", "<": "&lt;", "`": "'"})


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return 0, or 2 after one line on stderr."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    path = Path(words[0] if words else "build/grade/results.json")
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        found = at_lines.found_in(content)
        told = {
            "GITHUB_STEP_SUMMARY": markdown(content, found, Texts(content["language"])),
            "GITHUB_OUTPUT": f"result={encoded(classroom(content, found))}",
        }
        for variable, text in told.items():
            _tell(os.environ.get(variable, ""), text)
    except (OSError, ValueError, KeyError, TypeError) as error:
        return complain(f"{path}: {error}; make grade", ExitCode.WRONG_USE)
    return ExitCode.DONE


def classroom(content: Row, found: Sequence[Annotation]) -> dict[str, Any]:
    """Return the points of every exercise, as GitHub Classroom's reporter reads them."""
    places = {each.exercise: each for each in found}
    full = content["score"] >= content["max_score"] and not content["incomplete"]
    return {
        "version": VERSION,
        "status": "error" if content["incomplete"] else "pass" if full else "fail",
        "max_score": content["max_score"] + content["max_bonus"],
        "tests": [_test(each, places.get(each["id"])) for each in content["exercises"]],
    }


def _test(exercise: Row, place: Annotation | None) -> dict[str, Any]:
    status = {"passed": "pass", "error": "error"}.get(exercise["outcome"], "fail")
    return {
        "name": f"{exercise['id']} {exercise['function']} - {exercise['title']}",
        "status": status,
        "score": exercise["points"],
        "message": place.text if place else "",
        "filename": place.path if place else exercise["file"],
        "line_no": place.line if place else 0,
    }


def encoded(points: dict[str, Any]) -> str:
    """Return what Classroom's reporter takes: JSON in base64."""
    return base64.b64encode(json.dumps(points).encode()).decode()


def markdown(content: Row, found: Sequence[Annotation], texts: Texts) -> str:
    """Return the table of the exercises, then what is wrong, for a job's summary."""
    summary = Summary(content, texts)
    totals = [line for line, _ in summary.totals()]
    rows = [
        f"| {each['id']} | {_cell(each['title'])} | `{each['function']}` "
        f"| {_cell(texts.say('outcome.' + each['outcome']))} "
        f"| {texts.number(each['points'])} / {texts.number(each['max_points'])} |"
        for each in content["exercises"]
    ]
    wrong = [
        f"- **{_cell(each.title or each.path)}** ({_place(each)}) {_cell(each.text)}"
        for each in found
        if each.is_error
    ]
    head = f"| TP | | | | {texts.say('page.points')} |\n|---|---|---|---|---|"
    return "\n".join([*totals, "", head, *rows, "", *wrong, ""])


def _place(each: Annotation) -> str:
    return f"{_cell(each.path)}:{each.line}"


def _cell(text: str) -> str:
    """Return a text that stays in its cell, and is no HTML."""
    return text.translate(_CELL)


def _tell(path: str, text: str) -> None:
    if not path:
        sys.stdout.write(text + "\n")
        return
    with Path(path).open("a", encoding="utf-8") as file:
        file.write(text + "\n")


if __name__ == "__main__":
    sys.exit(main())
