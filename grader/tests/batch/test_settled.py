"""What the machine fails at twice, although it grades others, has the mark of what was judged.

And never because of the machine itself: then there is no mark, and the same command tries again.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from grader.authoring.specimens import classroom
from grader.authoring.specimens.student import STUDENT_MAIN, main_c
from grader.batch import cluster, command, grade_one, pool
from grader.batch.grade_one import BuildFolder, grade
from grader.batch.records import GradedFiles, Task
from grader.console.run import ExitCode
from grader.course import exercises
from grader.course.message import Message
from grader.evaluation.pipeline import run_checks
from grader.evaluation.records import Finding, Outcome
from grader.tests.batch import fake_grading
from grader.tests.batch.test_class import marks

LOST = "tp1.fill_rect.clipped"
Breaks = Callable[[Task, int], bool]  # a task, and how many were graded before it


class Machine:
    """A grader that compiles nothing; at what `breaks` tells it, one check cannot be made."""

    def __init__(self, breaks: Breaks) -> None:
        self.breaks = breaks
        self.graded: list[str] = []

    def run(self, tasks: Iterable[Task], *_: object) -> Iterator[GradedFiles]:
        """Grade as the pool does."""
        for task in tasks:
            content = fake_grading.graded(task)
            if broken := self.breaks(task, len(self.graded)):
                lost = {"id": LOST, "title": "", "outcome": Outcome.ERROR.value, "mistakes": []}
                content |= {"incomplete": True, "checks": [lost]}
            self.graded.append(task.name)
            files = {"results.json": json.dumps(content).encode(), "report.html": b"<p>"}
            yield GradedFiles(task.name, files, 1.0, 1.0, incomplete=broken)


@pytest.fixture
def machine(monkeypatch: pytest.MonkeyPatch) -> Machine:
    """Grade with a machine that always breaks at Eve's."""
    fake_grading.use(monkeypatch, pages=False)
    found = Machine(lambda task, _: task.name == "Eve")
    monkeypatch.setattr(pool, "run", found.run)
    monkeypatch.setattr(cluster, "run", found.run)
    return found


def lay(top: Path, **worth: float) -> None:
    """Write submissions that are worth so much."""
    for name, each in worth.items():
        (top / "in" / name).mkdir(parents=True)
        (top / "in" / name / "main.c").write_text(fake_grading.source(each, name), encoding="utf-8")


def batch(top: Path, *more: str) -> int:
    """Run the command."""
    words = [str(top / "in"), "--out", str(top / "out"), "--lang", "fr", "--jobs", "1"]
    return command.main([*words, *more])


def test_it_has_the_mark_of_what_was_judged(
    tmp_path: Path, machine: Machine, capfd: pytest.CaptureFixture[str]
) -> None:
    """Once it has failed before and after another one that passes; it is told, with the check."""
    lay(tmp_path, Ada=1.0, Eve=0.5, Grace=0.8)
    assert batch(tmp_path) == ExitCode.DONE
    assert machine.graded == ["Ada", "Eve", "Grace", "Ada", "Eve"]
    assert marks(tmp_path / "out") == {"Ada": [20], "Eve": [10], "Grace": [16]}
    said = capfd.readouterr().out
    assert f"La machine échoue deux fois sur des vérifications de ce rendu ({LOST})" in said


def test_it_is_graded_anew_only_when_asked(tmp_path: Path, machine: Machine) -> None:
    """Not at each run; once its folder is removed, and then as anybody's."""
    lay(tmp_path, Ada=1.0, Eve=0.5)
    assert batch(tmp_path) == ExitCode.DONE
    machine.graded.clear()
    assert batch(tmp_path) == ExitCode.DONE
    assert machine.graded == []
    assert marks(tmp_path / "out") == {"Ada": [20], "Eve": [10]}
    shutil.rmtree(tmp_path / "out" / "students" / "Eve")
    assert batch(tmp_path) == ExitCode.DONE
    assert machine.graded == ["Eve", "Ada", "Eve"]
    assert marks(tmp_path / "out") == {"Ada": [20], "Eve": [10]}
    shutil.rmtree(tmp_path / "out" / "students" / "Eve")
    machine.breaks = lambda *_: False
    lines = (tmp_path / "out" / "grades.csv").read_text(encoding="utf-8-sig")
    assert "échoue deux fois" in lines
    assert batch(tmp_path) == ExitCode.DONE
    lines = (tmp_path / "out" / "grades.csv").read_text(encoding="utf-8-sig")
    assert "échoue deux fois" not in lines


@pytest.mark.parametrize(
    ("breaks", "given"),
    [
        (lambda *_: True, [None, None]),  # at all of them
        (lambda _, before: before >= 1, [20, None]),  # from the second on
        (lambda task, before: task.name == "Eve" and before < 2, [20, 10]),  # once
    ],
    ids=["all", "from some time on", "once"],
)
def test_a_machine_that_fails_marks_nobody_down(
    tmp_path: Path, machine: Machine, breaks: Breaks, given: list[float | None]
) -> None:
    """Neither when nothing passes, nor when nothing passes any more; what passes then counts."""
    machine.breaks = breaks
    lay(tmp_path, Ada=1.0, Eve=0.5)
    assert batch(tmp_path) == (ExitCode.DONE if None not in given else ExitCode.FAILED)
    assert marks(tmp_path / "out") == {"Ada": given[:1], "Eve": given[1:]}
    machine.breaks = lambda *_: False
    assert batch(tmp_path) == ExitCode.DONE
    assert marks(tmp_path / "out") == {"Ada": [20], "Eve": [10]}


def test_on_a_cluster_it_has_none(tmp_path: Path, machine: Machine) -> None:
    """Which of the machines has failed is not known there."""
    lay(tmp_path, Ada=1.0, Eve=0.5)
    assert batch(tmp_path, "--scheduler", "tcp://127.0.0.1:1") == ExitCode.FAILED
    assert marks(tmp_path / "out") == {"Ada": [20], "Eve": [None]}


def test_without_any_result_there_is_no_mark(
    tmp_path: Path,
    machine: Machine,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    """Nothing was judged: the line says so, and how to give one."""

    def run(tasks: Iterable[Task], *_: object) -> Iterator[GradedFiles]:
        for each in machine.run(tasks):
            yield (
                replace(each, files={}, incomplete=False, failure="?") if each.incomplete else each
            )

    monkeypatch.setattr(pool, "run", run)
    lay(tmp_path, Ada=1.0, Eve=0.5, Grace=1.0)
    assert batch(tmp_path) == ExitCode.FAILED
    assert marks(tmp_path / "out") == {"Ada": [20], "Eve": [None], "Grace": [20]}
    assert "donnez une note dans manual.csv" in capfd.readouterr().out


@pytest.mark.long
def test_a_real_report_of_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its page says which check could not be made; the others' points are its mark."""
    error = Message("failure.error", {"detail": "the worker failed"})

    def checked(libraries: object, *words: object, **more: object) -> list[Finding]:
        found = run_checks(libraries, *words, **more)  # type: ignore[arg-type]
        if b"breaks" not in libraries.submission.files["main.c"]:  # type: ignore[attr-defined]
            return found
        lost = Outcome.ERROR
        return [
            replace(each, outcome=lost, message=error) if each.check == LOST else each
            for each in found
        ]

    monkeypatch.setattr(grade_one, "run_checks", checked)
    place = BuildFolder(tmp_path / "builds")
    place.folder.mkdir()
    monkeypatch.setattr(pool, "run", lambda tasks, *_: (grade(each, place) for each in tasks))
    classroom.first_tp(tmp_path / "in" / "Ada")
    classroom.first_tp(
        tmp_path / "in" / "Eve", {"main.c": f"{main_c(STUDENT_MAIN)}/* breaks it */\n"}
    )
    assert batch(tmp_path, "--isolation", "portable", "--yes") == ExitCode.DONE
    # Of 20, and to the next quarter.
    left = 3 - exercises.load().checks()[LOST].points / 100 / 5
    assert marks(tmp_path / "out") == {"Ada": [3], "Eve": [round(4 * left) / 4]}
    page = (tmp_path / "out" / "students" / "Eve" / "report.html").read_text(encoding="utf-8")
    assert "the worker failed" in page
