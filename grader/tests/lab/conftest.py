"""A folder of C files as a student has it, with the lab's tools turned to it."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from grader.course.exercises import CORE, ROOT
from grader.lab import Core
from grader.lab.bridge import engine
from grader.lab.cells.judge import JUDGE
from grader.tests.support.outputs import outputs

Edit = Callable[[str, str, str], None]


@pytest.fixture
def folder(tmp_path: Path, cache: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Return the reference as a student's folder; builds go to the cache that all tests share."""
    place = tmp_path / "core_c"
    shutil.copytree(CORE, place)
    for path in (ROOT / "reference").glob("*.[ch]"):
        shutil.copyfile(path, place / path.name)
    monkeypatch.setenv("MRT_CORE", str(place))
    monkeypatch.setenv("BUILD", str(outputs(tmp_path / "build", cache)))
    monkeypatch.setenv("MRT_LANG", "en")
    engine._latest.clear()  # another test's
    yield place
    JUDGE.close()
    JUDGE.done.clear()


@pytest.fixture
def core(folder: Path) -> Iterator[Core]:
    """Return the tool on that folder, with a small picture."""
    made = Core()
    made.size = (96, 64)
    yield made
    made.close()


@pytest.fixture
def edit(folder: Path) -> Edit:
    """Return a function that replaces a text once in a file of the folder, as an editor would."""

    def replace(name: str, old: str, new: str) -> None:
        path = folder / name
        text = path.read_text(encoding="utf-8")
        assert text.count(old) >= 1, old
        path.write_text(text.replace(old, new, 1), encoding="utf-8")

    return replace
