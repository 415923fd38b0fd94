"""A small class graded by the command, from the archives to the files that are given back."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import pytest

from grader.authoring.specimens import classroom
from grader.batch import csv_table
from grader.course.exercises import ROOT
from grader.course.texts import Texts
from grader.sandbox.levels import Level, best

SECONDS = 600


@dataclass(frozen=True)
class Run:
    """What a run of the command gave."""

    status: int
    said: str
    errors: str


def batch(path: Path, out: Path, *more: str) -> Run:
    """Run the command in a process of its own."""
    command = [
        sys.executable,
        "-m",
        "grader",
        "batch",
        str(path),
        "--out",
        str(out),
        "--public",
        *more,
    ]
    done = subprocess.run(
        command,
        cwd=ROOT,
        env={**os.environ, "MRT_LANG": "fr"},
        capture_output=True,
        text=True,
        timeout=SECONDS,
        check=False,
    )
    return Run(done.returncode, done.stdout, done.stderr)


@pytest.fixture(scope="module")
def top(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of this file's class; its name is hard on every path."""
    if best().level is not Level.STRONG:
        assert not os.environ.get("MRT_CI"), "CI must have bubblewrap"
        pytest.skip("bubblewrap is missing")
    return tmp_path_factory.mktemp("l'été, au labo")


@pytest.fixture(scope="module")
def pupils(top: Path) -> list[classroom.Pupil]:
    """Lay a class of the ten ordinary kinds."""
    return classroom.write(top / "in", 10)


@pytest.fixture(scope="module")
def first(top: Path, pupils: list[classroom.Pupil]) -> Run:
    """Grade it."""
    assert pupils
    return batch(top / "in", top / "out", "--jobs", "2", "--names")


def marks(out: Path) -> dict[str, list[float | None]]:
    """Return the marks of grades.csv by submission, in the order of its lines."""
    sheet = csv_table.read(out / "grades.csv")
    at = {name: sheet.header.index(name) for name in ("rendu", "note")}
    found: dict[str, list[float | None]] = {}
    for row in sheet.rows:
        found.setdefault(row[at["rendu"]], []).append(csv_table.number(row[at["note"]]))
    return found


def grades(out: Path) -> list[list[str]]:
    """Return grades.csv without the pseudonyms, which each folder of results has of its own."""
    sheet = csv_table.read(out / "grades.csv")
    at = sheet.header.index("pseudonyme")
    return [[cell for k, cell in enumerate(row) if k != at] for row in sheet.rows]


def test_every_mark_is_the_expected_one(
    top: Path, first: Run, pupils: list[classroom.Pupil]
) -> None:
    """Right, stubs, archives, a pair on two lines; what cannot be graded has no mark, no zero."""
    assert (first.status, "Traceback" in first.errors) == (0, False)
    assert marks(top / "out") == {
        each.name: [None if each.points is None else each.points / 5] * max(1, len(each.members))
        for each in pupils
    }
    assert not (top / "outside.c").exists()
    students = {path.name for path in (top / "out" / "students").iterdir()}
    assert students == {each.name for each in pupils if each.points is not None}
    for name in students:
        folder = top / "out" / "students" / name
        content = json.loads((folder / "results.json").read_text(encoding="utf-8"))
        assert content["isolation"] == "strong"
        assert all(not each["path"].startswith("/") for each in content["submission"]["sources"])
        assert str(ROOT) not in (folder / "report.html").read_text(encoding="utf-8")
    assert not (top / "out" / "work").exists()


def test_again_is_the_cache_and_the_same_bytes(top: Path, first: Run) -> None:
    """Nothing is graded; grades.csv does not change, and no mark is said to."""
    assert first.status == 0
    before = (top / "out" / "grades.csv").read_bytes()
    stamps = {path: path.stat().st_mtime_ns for path in (top / "out" / "state").iterdir()}
    again = batch(top / "in", top / "out")
    said = Texts("fr").say("batch.on_public") + "\n"
    assert (again.status, again.errors) == (0, said)
    assert {path: path.stat().st_mtime_ns for path in (top / "out" / "state").iterdir()} == stamps
    assert (top / "out" / "grades.csv").read_bytes() == before
    assert "Notes qui changent" not in again.said
    assert not (top / "out" / "changes.csv").exists()


def test_worksheet_manual_marks_and_lateness(
    top: Path, first: Run, pupils: list[classroom.Pupil]
) -> None:
    """Beside the submissions: read at each run, without grading anything again."""
    assert first.status == 0
    full = next(each.name for each in pupils if each.kind == "full")
    tp1 = next(each.name for each in pupils if each.kind == "tp1")
    header = "Identifier,Full name,Grade,Maximum grade,Last modified (submission)\r\n"
    when = '"Tuesday, 3 March 2026, 10:00 AM"'
    rows = f'Participant 7,"{full}",,20.00,{when}\r\nParticipant 8,"{tp1}",,20.00,-\r\n'
    rows += "Participant 9,Absent Ami,,20.00,-\r\n"
    (top / "in" / "notes.csv").write_text(header + rows, encoding="utf-8")
    (top / "in" / "manual.csv").write_text(
        f"who;dessin;override;reason\n{tp1};1,5;;\n", encoding="utf-8"
    )
    (top / "in" / "course.toml").write_text(
        "[deadlines]\nTP5 = 2026-03-02T09:00:00\n[late]\nper_day = 2\n[people]\nabsent = 0\n",
        encoding="utf-8",
    )
    done = batch(top / "in", top / "out")
    assert done.status == 0
    content = (top / "out" / "moodle" / "notes.csv").read_bytes().decode()
    grades = {row[0]: row[2] for row in csv.reader(content.splitlines()[1:])}
    assert grades == {"Participant 7": "16.00", "Participant 8": "4.50", "Participant 9": "0.00"}
    assert f"{full} : 20 -> 16" in done.said
    assert (top / "out" / "moodle" / "feedback.zip").exists()
    (top / "in" / "manual.csv").write_text("who;dessin\nnobody;1\n", encoding="utf-8")
    wrong = batch(top / "in", top / "out")
    assert wrong.status == 3
    assert "manual.csv, ligne 2 : « nobody » n'est personne de la classe." in wrong.errors
    for name in ("notes.csv", "manual.csv", "course.toml"):
        (top / "in" / name).unlink()


@pytest.mark.exhaustive
def test_a_batch_that_is_killed_goes_on(
    top: Path, first: Run, pupils: list[classroom.Pupil]
) -> None:
    """By kill -9, after the first result: the same command ends with the same grades."""
    assert first.status == 0
    few = top / "few"
    few.mkdir()
    for each in pupils[:3]:
        os.rename(top / "in" / each.name, few / each.name)
    whole = batch(few, top / "whole")
    assert whole.status == 0
    command = [sys.executable, "-m", "grader", "batch", str(few), "--out", str(top / "killed")]
    command.append("--public")
    process = subprocess.Popen(
        [*command, "--jobs", "1"],
        cwd=ROOT,
        env={**os.environ, "MRT_LANG": "fr"},
        stderr=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
    )
    state = top / "killed" / "state"
    end = time.monotonic() + SECONDS
    while not (state.is_dir() and list(state.iterdir())) and time.monotonic() < end:
        time.sleep(0.05)
    process.send_signal(signal.SIGKILL)
    process.wait(60)
    done = [path.name for path in state.iterdir()]
    stamps = {name: (state / name).stat().st_mtime_ns for name in done}
    assert 0 < len(done) < 3
    resumed = batch(few, top / "killed")
    assert resumed.status == 0
    assert {name: (state / name).stat().st_mtime_ns for name in done} == stamps
    assert grades(top / "whole") == grades(top / "killed")


def test_a_batch_needs_strong_isolation(top: Path) -> None:
    """Where it cannot be had: refused before anything is graded, with the word to type."""
    done = subprocess.run(
        [sys.executable, "-m", "grader", "batch", str(top / "in"), "--out", str(top / "none")],
        cwd=ROOT,
        env={**os.environ, "PATH": str(top), "CC": "/usr/bin/gcc", "MRT_LANG": "fr"},
        capture_output=True,
        text=True,
        timeout=SECONDS,
        check=False,
    )
    assert (done.returncode, (top / "none").exists()) == (3, False)
    assert "ISOLATION=medium" in done.stderr
