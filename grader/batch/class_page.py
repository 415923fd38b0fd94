"""index.html: the class on one page that needs nothing else, for any browser.

Without `names` it can be shown in a lecture: pseudonyms, and no link to a student's page.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

from grader.batch import grades_csv, statistics
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
    names: bool,
    texts: Texts,
    folder: Path,
) -> str:
    """Return the page of a class; `folder` holds those of the students, with their pictures."""
    made = page.environment(texts, TEMPLATES, "class.css", "class.js")
    rows = _rows(marks, graded, names, texts)
    return made.get_template("class.html").render(
        numbers=statistics.of(marks, graded, course.marks.scale, texts.language),
        scale=course.marks.scale,
        failures=[each for each in rows if each["error"]],
        waiting=[each for each in rows if each["mark"] is None and not each["error"]],
        rows=rows,
        names=names,
        pictures=_pictures(rows, folder),
        mistake=lambda name: texts.get(f"mistake.{name}.title", name),
    )


def _rows(
    marks: Sequence[Mark], graded: Mapping[str, Graded], names: bool, texts: Texts
) -> list[dict[str, Any]]:
    """Return a line for each person; when pseudonymous, in an order that tells nothing."""
    hidden = grades_csv.pseudonyms(marks)
    rows = []
    for each in marks:
        name = each.member.submission
        known = graded.get(name)
        results = known.results if known and known.results else None
        outcomes = [outcome for outcome, _, _ in results["exercises"].values()] if results else []
        link = f"{STUDENTS}/{quote(name)}/{page.NAME}" if names and results else ""
        rows.append(
            {
                "name": each.member.name if names else hidden.get(name, "-"),
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
    return rows if names else sorted(rows, key=lambda row: str(row["name"]))


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
