"""A class whose sentences have changed: its pages tell the new ones, and nobody is graded again."""

from __future__ import annotations

import json
import shutil
import zipfile
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from grader.batch import dependencies, pool
from grader.batch.dependencies import WORDING
from grader.batch.records import GradedFiles, Settings, Task
from grader.course import texts
from grader.report.page import NAME
from grader.tests.batch import fake_grading
from grader.tests.batch.desk_class import Laid, packed, row, submission, table
from grader.tests.support.reports import every_outcome

NEW = "Where does the row of a pixel begin?"


@pytest.fixture
def words(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., None]]:
    """Return a function that changes a sentence of a copy of messages/, or writes another file."""
    folder = tmp_path / "messages"
    shutil.copytree(texts.FOLDER, folder)
    monkeypatch.setattr(texts, "FOLDER", folder)

    def forget() -> None:
        texts.sentences.cache_clear()
        dependencies._common.cache_clear()

    def change(old: str, new: str, path: str) -> None:
        text = (folder / path).read_text(encoding="utf-8")
        assert text.count(old) == 1
        (folder / path).write_text(text.replace(old, new), encoding="utf-8")
        forget()

    forget()
    yield change
    forget()


@pytest.fixture
def graded(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return the names of the submissions that are graded; each has a report with hints."""
    fake_grading.use(monkeypatch)
    found: list[str] = []

    def run(tasks: Iterable[Task]) -> Iterator[GradedFiles]:
        for task in tasks:
            found.append(task.name)
            content = every_outcome(task.settings.language)
            checks = [each for each in content["checks"] if each["outcome"] != "error"]
            content |= {"checks": checks, "incomplete": False}
            data = json.dumps(content).encode()
            yield GradedFiles(task.name, {"results.json": data, NAME: b"<p>"}, 1.0, 1.0)

    monkeypatch.setattr(pool, "run", lambda tasks, *_: run(tasks))
    return found


@pytest.fixture
def a_class(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Laid:
    """Return a class of two, with their worksheet."""
    laid = Laid(tmp_path / "class", capsys)
    laid.folder.mkdir()
    people = {101: "Ada Lovelace", 102: "Alan Turing"}
    laid.archive(
        {
            f"{name}_{number}_assignsubmission_file_/r.zip": packed(submission(1.0, also=name))
            for number, name in people.items()
        }
    )
    laid.write("w.csv", table([row(*each) for each in people.items()]))
    return laid


def question() -> tuple[str, str]:
    """Return a question that is asked in these reports, and how its file has it."""
    check = next(each for each in every_outcome("en")["checks"] if each["outcome"] == "failed")
    return check["hint"], json.dumps(check["hint"], ensure_ascii=False)


def test_a_mended_hint_grades_nobody_again(
    a_class: Laid, graded: list[str], words: Callable[..., None]
) -> None:
    """Results, pages and feedback tell it; marks stay; a third run changes no byte."""
    first = a_class.run()
    marks = first.marks()
    assert len(graded) == 2
    old, written = question()
    words(written, json.dumps(NEW), "en/checks.toml")
    second = a_class.run()
    assert len(graded) == 2
    assert second.marks() == marks
    pages = sorted((second.out / "students").glob(f"*/{NAME}"))
    assert len(pages) == 2
    for page in pages:
        shown = page.read_text(encoding="utf-8")
        assert NEW in shown
        assert old not in shown
        kept = (page.parent / "results.json").read_text(encoding="utf-8")
        assert json.dumps(NEW)[1:-1] in kept
    with zipfile.ZipFile(second.out / "moodle" / "feedback.zip") as archive:
        assert all(NEW in archive.read(name).decode() for name in archive.namelist())
    before = {path: path.read_bytes() for path in (second.out / "students").rglob("*.*")}
    third = a_class.run()
    assert len(graded) == 2
    assert before == {path: path.read_bytes() for path in (third.out / "students").rglob("*.*")}


def test_another_language_or_level_of_help_grades_nobody_again(
    a_class: Laid, graded: list[str]
) -> None:
    """The page is in French then, with the most direct hint."""
    a_class.run()
    french = a_class.run("--lang", "fr", "--hint", "3")
    assert len(graded) == 2
    page = next((french.out / "students").glob(f"*/{NAME}")).read_text(encoding="utf-8")
    assert '<html lang="fr"' in page
    content = json.loads(
        next((french.out / "students").glob("*/results.json")).read_text(encoding="utf-8")
    )
    wrong = next(each for each in content["checks"] if each["outcome"] == "failed")
    assert (content["language"], wrong["words"]["level"]) == ("fr", 3)


def test_the_frame_of_a_page_is_told_again_too(
    a_class: Laid, graded: list[str], words: Callable[..., None]
) -> None:
    """What stands in no results.json."""
    a_class.run()
    words('title = "Report: {name}"', 'title = "What {name} has done"', "en/report.toml")
    done = a_class.run()
    page = next((done.out / "students").glob(f"*/{NAME}")).read_text(encoding="utf-8")
    assert "<h1>What " in page
    assert len(graded) == 2


def test_what_a_result_depends_on(words: Callable[..., None]) -> None:
    """Sentences are a part of their own; a new kind of death is told by grading alone."""
    settings = Settings("en", "strong")
    task = Task(
        "ada", "Ada", {}, dict.fromkeys(("missing", "refused", "changed", "converted")), settings
    )

    def changed(before: dict[str, str], other: Task = task) -> set[str]:
        now = dependencies.parts_of(other)
        return {part for part in now if now[part] != before[part]}

    parts = dependencies.parts_of(task)
    assert changed(parts) == set()
    hinted = replace(task, settings=replace(settings, hint=2, language="fr"))
    assert changed(parts, hinted) == {WORDING}
    shut = replace(task, settings=replace(settings, isolation="medium"))
    assert changed(parts, shut) == {"settings"}
    words('expected = "expected:"', 'expected = "wanted:"', "en/report.toml")
    assert changed(parts) == {WORDING}
    words("SIGSEGV = ", "SIGTRAP = ", "en/deaths.toml")
    assert changed(parts) == {WORDING, "grader"}
