"""What the autograders of other platforms share: the project in an archive, and a class of one.

A submission is graded by `make batch`, with its budgets and its unseen inputs, whatever the
platform; what a platform reads is made of the results.
"""

from __future__ import annotations

import csv
import json
import shutil
from collections.abc import Collection
from pathlib import Path
from typing import Any

from grader.authoring import release
from grader.batch import command
from grader.batch.grades_csv import GRADES
from grader.batch.results_folder import STUDENTS
from grader.course.message import UserError
from grader.sandbox.levels import Level, current

TOP = "miniraytracer"  # the project's folder in an archive
_CLASS, _NAME = "class", "rendu"
_LEFT_OUT = ("grader/tests/", ".ci/", ".vscode/", ".devcontainer/")


class AutograderError(UserError):
    """An archive cannot be made, or used: a sentence of [autograder] in messages/."""


def project(root: Path) -> dict[str, bytes]:
    """Return what git tracks, by its place in an archive. Raises AutograderError, ReleaseError."""
    tracked = [each for each in release.git(root, "ls-files", "-z").split("\0") if each]
    if not tracked:
        raise AutograderError("autograder.no_git", path=root)
    names = [each for each in tracked if not each.startswith(_LEFT_OUT)]
    return {f"{TOP}/{name}": release.read(root, name) for name in names}


def expect_isolation() -> None:
    """Raise AutograderError where a submission could read the solution."""
    if current().level is Level.PORTABLE:
        raise AutograderError("autograder.no_isolation")


def results_of(root: Path) -> Path:
    """Return the folder of results of a class of one, below a folder of the platform."""
    return root / _CLASS / "results"


def grade(files: Path, root: Path, leave: Collection[str] = ()) -> int:
    """Grade a folder, but for the files to leave, as a class of one; return the exit code."""
    handed_in = root / _CLASS / "handed_in"
    for old in (handed_in, results_of(root) / STUDENTS):
        shutil.rmtree(old, ignore_errors=True)
    ignore = shutil.ignore_patterns(*leave)
    shutil.copytree(files, handed_in / _NAME, symlinks=True, ignore=ignore)
    words = [str(handed_in), "--out", str(results_of(root))]
    return command.main([*words, "--isolation", current().level.value, "--again"])


def graded(root: Path) -> tuple[dict[str, Any] | None, Path]:
    """Return the results of the submission, if it has some, and the folder of its pictures."""
    path = results_of(root) / STUDENTS / _NAME / "results.json"
    content = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else None
    return content, path.parent


def reason(root: Path) -> str:
    """Return why the submission has no mark: the last column of grades.csv."""
    with (results_of(root) / GRADES).open(encoding="utf-8-sig", newline="") as file:
        rows = list(csv.reader(file, delimiter=";"))
    return rows[-1][-1]
