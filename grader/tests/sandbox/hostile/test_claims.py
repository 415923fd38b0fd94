"""What the instructors' page says of each level is what is seen: no claim without its test."""

from __future__ import annotations

import ast
import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from grader.authoring.specimens import hostile
from grader.authoring.specimens.hostile import Quick
from grader.authoring.specimens.student import STUDENT_MAIN, main_c
from grader.course.exercises import PACKAGE, ROOT
from grader.execution.canary import prove
from grader.execution.session import open_core
from grader.execution.worker_process import Died
from grader.sandbox.levels import IsolationError, Level, using

PAGE = (ROOT / "INSTRUCTORS.md").read_text(encoding="utf-8")
# The rows of the page's table by level, and what is tried: an act of the canary, or one of ours.
ACTS = {
    "read the files that your account, or nobody's when root grades, can read": "read",
    "write there": "write",
    "have the compiler take them in": "include",
    "list folders": "list",
    "ask whether a file is there, and its size": "size",
    "use the network": "network",
    "start other programs": "process",
    "leave shared memory behind": "memory",
    "compute or wait beyond its limits": "time",
    "read what you have in your environment": "environment",
}
SPY = """
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
void spy(color *img);
void spy(color *img) {
    struct stat about;
    DIR *folder = opendir("/usr");
    img[0].x = folder != NULL && readdir(folder) != NULL;
    img[0].y = stat("@ROOT@/INSTRUCTORS.md", &about) == 0 && about.st_size > 0;
    img[0].z = getenv("MRT_OWN_SECRET") != NULL;
}
"""
# What holds each row of the table of what is stopped.
HELD = {
    "reading the solution, the expected data": (
        *("test_hostile.py::test_a_hostile_program_gets_nowhere", "test_secrets.py::test_running"),
        *("test_secrets.py::test_compiling", "test_scanner.py::test_nothing_of_the_solution"),
    ),
    "answers known by heart": (
        *("test_fresh_inputs.py::test_the_real_ones", "test_fresh_inputs.py::test_the_seed_is"),
        "test_fresh_inputs.py::test_who_is_right_on_the_archive_alone",
    ),
    "forging a mark": (
        "test_nothing_expected_is_sent.py::test_what_is_wrong",
        "test_hostile.py::test_what_acts_while_loading_gains_nothing",
        "test_tools.py::test_what_a_source_says_changes_no_status",
    ),
    "network, other processes": ("test_hostile.py::test_a_hostile_program_gets_nowhere",),
    "filling memory, disk or time": (
        *("test_hostile.py::test_memory_is_bounded", "test_budget.py::test_each_kind_is_spent"),
        *("test_patience.py::test_a_submission_that_sleeps", "test_found.py::test_nobody_s_files"),
        *("test_submission.py::test_many_large_files", "test_patterns.py::test_no_text_is_slow"),
    ),
    "a hand-in that poses as": ("test_cases.py::test_a_students_file_is_never_the_courses",),
    "other users of the machine": ("test_closed_folders.py::test_another_user_reads_nothing",),
    "acting on your spreadsheet or browser": (
        *("test_cases.py::test_odd_names_keep", "test_report_page.py::test_"),
    ),
    "a submission's traces": ("test_crew.py::test_a_worker_keeps_nothing_of_a_submission",),
}


def rows(head: str) -> Iterator[list[str]]:
    """Yield the rows of the page's table that begins so."""
    lines = PAGE[PAGE.index(head) :].splitlines()[2:]
    for line in lines:
        if not line.startswith("|"):
            return
        yield [each.strip() for each in line.strip("|").split("|")]


@pytest.fixture(params=list(Level))
def level(request: pytest.FixtureRequest) -> Iterator[Level]:
    """Work at each level that this machine has."""
    try:
        with using(request.param):
            yield request.param
    except IsolationError as error:
        assert not os.environ.get("MRT_CI"), "CI must have bubblewrap"
        pytest.skip(f"not on this machine: {error.best.reason}")


def test_each_level_lets_through_what_the_page_says(
    level: Level, tmp_path: Path, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By trying: no more, and no less."""
    monkeypatch.setenv("MRT_OWN_SECRET", "1")
    bodies = {
        "fill_red": "extern void spy(color *); spy(img);",
        "fill": "for (volatile int k = 1; k;) { } (void)img, (void)c;",
    }
    spy = SPY.replace("@ROOT@", str(ROOT))
    files = {"main.c": main_c({**STUDENT_MAIN, **bodies}), "spy.c": hostile.INCLUDE + spy}
    folder = hostile.lay(tmp_path / "rendu", files)
    could = {*prove(cache).permitted}
    picture = np.zeros((96 * 64, 3), np.float32)
    with open_core(folder, 96, 64, cache=cache) as core:
        with core.session(Quick()) as session:
            seen = session.call("fill_red", picture).args["img"][0]
        with core.session(Quick()) as session, pytest.raises(Died):
            session.call("fill", picture, (1, 1, 1))
    could |= {act for act, it in zip(("list", "size", "environment"), seen, strict=True) if it}
    column = [*Level].index(level) + 1
    said = {row[0]: row[column] for row in rows("| while a submission is compiled or runs")}
    assert said == {row: "yes" if act in could else "no" for row, act in ACTS.items()}


def test_each_claim_has_its_tests() -> None:
    """A row of what is stopped, and the tests that hold it."""
    found = set()
    for path in (PACKAGE / "tests").rglob("test_*.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        found |= {f"{path.name}::{n.name}" for n in tree.body if isinstance(n, ast.FunctionDef)}
    claims = [row[0] for row in rows("| stopped at level `strong`")]
    assert len(claims) == len(HELD)
    for claim, start in zip(claims, HELD, strict=True):
        assert claim.startswith(start)
        for test in HELD[start]:
            assert any(each.startswith(test) for each in found), test
