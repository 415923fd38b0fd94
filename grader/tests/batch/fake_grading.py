"""A grader that compiles nothing, to try the desk alone: a submission says what it is worth.

`/* worth 0.85 */` in main.c earns that share of each exercise's points; nothing else counts, but
that `/* learnt TP2.1 */` is one that is right on the inputs of the archive alone.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import pytest

from grader.batch import command, fresh_inputs, pool
from grader.batch.records import GradedFiles, Task
from grader.build.records import BuildResult, BuildStatus, Target
from grader.course import exercises
from grader.course.texts import Texts
from grader.evaluation.records import ExerciseResult, Outcome, Report
from grader.intake.records import Submission
from grader.report import page, results

_LEARNT = re.compile(rb"/\* learnt (\S+) \*/")
_WORTH = re.compile(rb"/\* worth ([0-9.]+) \*/")


def source(worth: float, also: str = "") -> str:
    """Return a main.c that is worth this share of the points; `also` makes it somebody's own."""
    return f"void fill_red(color *img) {{ }} /* worth {worth:g} */ /* {also} */\n"


def use(monkeypatch: pytest.MonkeyPatch, *, pages: bool = True) -> None:
    """Have `batch` grade so; without pages, those of students are a few words, quickly made."""
    monkeypatch.setattr(pool, "run", lambda tasks, *_: run(tasks))
    monkeypatch.setattr(command, "_prove", lambda *_: None)
    monkeypatch.setattr(fresh_inputs, "make", _make)
    if not pages:
        monkeypatch.setattr(page, "render", lambda content, _: shown(content))


def _make(seed: int, folder: Path) -> None:
    """Stand for the making of inputs that nobody has seen."""
    folder.mkdir()
    (folder / "manifest.json").write_text(f"{seed}", encoding="utf-8")
    (folder / "made_of").write_text(fresh_inputs._key(seed), encoding="utf-8")


def shown(content: Any) -> str:
    """Return a page of nothing but what the desk adds to it."""
    return json.dumps([content["submission"]["name"], *content["notes"]], ensure_ascii=False)


def run(tasks: Iterable[Task]) -> Iterator[GradedFiles]:
    """Grade as the crew does."""
    for task in tasks:
        content = json.dumps(graded(task)).encode()
        yield GradedFiles(task.name, {"results.json": content, "report.html": b"<p>"}, 1.0, 1.0)


def graded(task: Task) -> dict[str, Any]:
    """Return the content of results.json."""
    found = _WORTH.search(task.files.get("main.c", b""))
    worth = float(found[1]) if found else 0.0
    rows = [
        ExerciseResult(
            *(each.id, each.tp, each.functions[0], each.file, Texts("en").title(each), each.bonus),
            outcome=Outcome.PASSED if worth == 1 else Outcome.FAILED if worth else Outcome.TODO,
            points=0 if each.bonus else round(each.points * worth),
            max_points=each.points,
        )
        for each in exercises.load().exercises
    ]
    report = Report(
        Submission(task.label, task.files, (), sources=task.submission["sources"]),
        task.settings.language,
        (BuildResult(BuildStatus.BUILT, Target(8, 8)),),
        checks=(),
        exercises=tuple(rows),
        graded_at=0.0,
        opened=tuple(exercises.load().tps),
        isolation=task.settings.isolation,
        learnt=tuple(each.decode() for each in _LEARNT.findall(task.files.get("main.c", b""))),
    )
    return results.as_json(report, Texts(task.settings.language))
