"""index.html: the class on one page that needs nothing else, for any browser.

Without `names` it can be shown in a lecture: pseudonyms, and no link to a student's page.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

from grader.batch import alike_list, grades_csv, statistics
from grader.batch.records import Graded, Mark
from grader.batch.results_folder import STUDENTS
from grader.course.settings import Course
from grader.course.texts import Texts
from grader.report import page

NAME = "index.html"
PICTURES = ("drawing", "final")
TEMPLATES = Path(__file__).parent / "templates"


def render(
    marks: Sequence[Mark],
    graded: Mapping[str, Graded],
    course: Course,
    hidden: Mapping[str, str] | None,
    texts: Texts,
    folder: Path,
) -> str:
    """Return the page of a class; `folder` holds those of the students, with their pictures.

    `hidden` are the pseudonyms of the submissions; without, the page has names.
    """
    made = page.environment(texts, TEMPLATES, "class.css", "class.js")
    names, scale = hidden is None, course.marks.scale
    rows = _rows(marks, graded, hidden, texts)
    rows = rows if names else sorted(rows, key=lambda row: str(row["name"]))
    return made.get_template("class.html").render(
        numbers=statistics.of(marks, graded, scale, texts),
        scale=scale,
        title=_titles(graded, folder),
        failures=[each for each in rows if each["error"]],
        waiting=[each for each in rows if each["mark"] is None and not each["error"]],
        rows=rows,
        names=names,
        alike=alike_list.read(folder.parent, graded, names),
        alike_page=alike_list.PAGE,
        pictures=_pictures(rows, folder),
        mistake=lambda name: texts.get(f"mistake.{name}.title", name),
    )


def shown_names(marks: Sequence[Mark]) -> dict[Mark, str]:
    """Return the name of each person as it is shown: namesakes have their number beside it."""
    names = Counter(each.member.name for each in marks)
    found = {}
    for each in marks:
        member = each.member
        number = member.number or member.moodle or member.submission
        alone = names[member.name] == 1 or not number
        found[each] = member.name if alone else f"{member.name} ({number})"
    return found


def _titles(graded: Mapping[str, Graded], folder: Path) -> dict[str, str]:
    """Return the titles of the checks, in the language in which submissions were graded."""
    for name, known in graded.items():
        path = folder / name / "results.json"
        if known.results and path.is_file():
            content = json.loads(path.read_text(encoding="utf-8"))
            return {each["id"]: each["title"] for each in content["checks"]}
    return {}


def _rows(
    marks: Sequence[Mark],
    graded: Mapping[str, Graded],
    hidden: Mapping[str, str] | None,
    texts: Texts,
) -> list[dict[str, Any]]:
    """Return a line for each person; with pseudonyms, nothing that says who it is."""
    names = hidden is None
    shown = shown_names(marks)
    rows = []
    for each in marks:
        name = each.member.submission
        known = graded.get(name)
        results = known.results if known and known.results else None
        outcomes = [outcome for outcome, _, _ in results["exercises"].values()] if results else []
        link = f"{STUDENTS}/{quote(name)}/{page.NAME}" if names and results else ""
        rows.append(
            {
                "name": shown[each] if hidden is None else hidden.get(name, "-"),
                "folder": name,
                "link": link,
                "mark": each.value,
                "tps": {row["tp"]: row for row in results["tps"]} if results else {},
                "bad": {key: outcomes.count(key) for key in ("crashed", "timeout")},
                # Sentences may name a person.
                "why": grades_csv.sentence(each, texts) if names else [],
                "seconds": known.seconds if known and results else None,
                "error": each.error,
            }
        )
    return rows


def _pictures(rows: Sequence[Mapping[str, Any]], folder: Path) -> list[dict[str, str]]:
    """Return the pictures of the gallery, each submission's once."""
    found: dict[str, dict[str, str]] = {}
    for row in rows:
        for name in PICTURES if row["folder"] else ():
            uri = page.data_uri(folder / row["folder"], f"gallery/{name}.png")
            if uri:
                key = f"{row['folder']}/{name}"
                found.setdefault(key, {"uri": uri, "kind": name, "name": row["name"]})
    return list(found.values())
