"""What lies on the disk while somebody grades is closed to the other users of the machine."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from grader.batch.results_folder import ResultsFolder
from grader.course.exercises import ROOT
from grader.execution.session import Library, open_core
from grader.sandbox.levels import IsolationError, Level, using
from grader.sandbox.staging import stage

STRANGER = 54321  # neither who grades nor whom root becomes
# Prints each file that it can open, wherever it can list folders.
LOOK = """
import os, sys
for folder, _, names in os.walk(sys.argv[1]):
    for name in names:
        try:
            open(os.path.join(folder, name), "rb").close()
        except OSError:
            continue
        print(os.path.join(folder, name))
"""


@pytest.fixture
def top(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Return a folder that everybody can enter, where temporary files are too."""
    if os.geteuid() != 0:
        pytest.skip("only root can look as somebody else")
    stage()  # is this process's, and outlives the test
    with tempfile.TemporaryDirectory(prefix="mrt-open-", dir="/tmp") as name:
        folder = Path(name)
        folder.chmod(0o755)
        (folder / "tmp").mkdir()
        monkeypatch.setattr(tempfile, "tempdir", str(folder / "tmp"))
        yield folder


def seen(top: Path) -> list[str]:
    """Return the files below a folder that another user opens; the worker's own are nobody's."""
    command = [sys.executable, "-S", "-c", LOOK, str(top)]
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
        cwd="/",
        user=STRANGER,
        group=STRANGER,
        extra_groups=[],
    )
    return [each for each in done.stdout.splitlines() if not each.startswith(f"{stage()}/")]


def everything(top: Path) -> list[str]:
    """Return the libraries, objects and sources that there are below a folder."""
    return [str(each) for each in top.rglob("*") if each.suffix in (".so", ".o", ".c")]


@pytest.mark.parametrize("level", list(Level))
def test_another_user_reads_nothing_while_code_runs(top: Path, level: Level) -> None:
    """Neither the solution's libraries nor its objects, where they are built and where they run."""
    try:
        with using(level), open_core(ROOT / "reference", 96, 64, cache=top / "cache") as core:
            check_closed(top, core)
    except IsolationError as error:
        pytest.skip(f"not on this machine: {error.best.reason}")


def check_closed(top: Path, core: Library) -> None:
    """Hold that the library runs, that there is something to steal, and that nothing is."""
    with core.session() as session:
        session.call("fill", core.zeros("vec3", 96 * 64), (1, 0, 0))
        assert any("inbox" in each for each in everything(top))
        assert any("cache" in each for each in everything(top))
        assert seen(top) == []


def test_another_user_reads_nothing_of_a_batch_s_work(top: Path) -> None:
    """Submissions that are unpacked, and what is built of them and of the solution."""
    with ResultsFolder(top / "out") as results:
        (results.work / "unpacked").mkdir()
        (results.work / "unpacked" / "main.c").touch()
        assert everything(top)
        assert [each for each in seen(top) if results.work.name in Path(each).parts] == []


def test_the_look_finds_what_lies_open(top: Path) -> None:
    """Or the tests above would hold whatever happens."""
    (top / "library.so").touch()
    assert seen(top) == [str(top / "library.so")]
