"""The instructors' page, followed to the letter: from the archive handed out to the last purge.

The commands are those that stand in INSTRUCTORS.md, in a copy of the project of its own; only the
machine's address, the place of the project and the number of workers are filled in.
"""

from __future__ import annotations

import csv
import io
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from grader.authoring.specimens.student import STUDENT_MAIN, main_c
from grader.tests.batch import moodle_site
from grader.tests.batch.moodle_site import Person, Site
from grader.tests.support.shell import ROOT, run

pytestmark = pytest.mark.exhaustive
PAGE = (ROOT / "INSTRUCTORS.md").read_text(encoding="utf-8")
ARCHIVE = "TP - 2026-1234.zip"
START_SECONDS = 60


def command(beginning: str) -> str:
    """Return the one command of the page that is this, or begins so, without its comment."""
    blocks = "".join(re.findall(r"```sh\n(.*?)```", PAGE, re.DOTALL))
    lines = [line.split("   #")[0].rstrip() for line in blocks.splitlines()]
    whole = [line for line in lines if line == beginning]
    (found,) = whole or [line for line in lines if line.startswith(beginning)]
    return found


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a copy of the project, as an instructor has it."""
    made = tmp_path_factory.mktemp("cours") / "sujet"
    made.mkdir()
    leave = shutil.ignore_patterns("__pycache__", "mrt", "*.o", ".ipynb_checkpoints")
    for name in ("core_c", "grader", "notebooks", "reference"):
        shutil.copytree(ROOT / name, made / name, ignore=leave)
    for path in ROOT.iterdir():
        if path.is_file() and path.name != ".git":  # a worktree's
            shutil.copy(path, made)
    return made


def follow(line: str, folder: Path) -> str:
    """Run a line of the page in a folder; return what it says, which must be no failure."""
    done = run("sh", "-c", line, cwd=folder, MRT_ENV=sys.prefix)
    assert done.returncode == 0, f"{line}\n{done.stdout}{done.stderr}"
    return done.stdout + done.stderr


def handed_in(project: Path, name: str, bodies: dict[str, str]) -> Path:
    """Return what a student hands in, from the archive that was handed out."""
    home = project.parent / name
    with zipfile.ZipFile(project / "miniraytracer.zip") as archive:
        archive.extractall(home)
    (folder,) = home.iterdir()
    (folder / "core_c" / "main.c").write_text(main_c(bodies), encoding="utf-8")
    given, family = name.split()
    authors = f"{family}, {given}, 2190{len(name):04d}\n"
    (folder / "core_c" / "AUTEURS.txt").write_text(authors, encoding="utf-8")
    follow("make submit", folder)
    (made,) = folder.glob("rendu-*.zip")
    return made


def marks(folder: Path) -> dict[str, str]:
    """Return the mark of each line of grades.csv."""
    text = (folder / "grades.csv").read_text(encoding="utf-8-sig")
    rows = csv.DictReader(io.StringIO(text), delimiter=";")
    return {row["nom"]: row["note"] for row in rows}


@pytest.fixture(scope="module")
def work(project: Path) -> dict[str, bytes]:
    """Return what two students hand in: all of TP1, and one function less."""
    follow(command("make release"), project)
    less = {**STUDENT_MAIN, "fill_circle": "(void)img, (void)radius, (void)center, (void)c;"}
    made = {"Ada Lovelace": STUDENT_MAIN, "Zoé Lefèvre": less}
    return {name: handed_in(project, name, each).read_bytes() for name, each in made.items()}


def test_a_folder_is_graded_and_purged(project: Path, work: dict[str, bytes]) -> None:
    """One archive for each submission; after the purge nothing is left."""
    (project / "rendus").mkdir()
    for name, content in work.items():
        (project / "rendus" / f"{name}.zip").write_bytes(content)
    follow(command("make batch SUBMISSIONS=rendus/ OUT=notes/"), project)
    assert {*marks(project / "notes")} == {*work}
    follow(command("make purge"), project)
    assert not (project / "notes").exists()


def site(project: Path, work: dict[str, bytes]) -> Site:
    """Return a site with the class, whose archive and worksheet lie in the project."""
    made = Site("fr", now=1_772_500_000.0)
    with zipfile.ZipFile(project / ARCHIVE, "w") as archive:
        for number, (name, content) in enumerate(work.items(), start=4001):
            made.people[str(number)] = Person(name, "", 1_772_488_740.0)
            archive.writestr(f"{name}_{number}_assignsubmission_file/rendu.zip", content)
    made.people["4009"] = Person("Paul Absent")
    (project / "Notes.csv").write_text(made.worksheet(";"), encoding="utf-8")
    return made


def grades(to: Site) -> list[float | None]:
    """Return the grades on the site."""
    return [each.grade for each in to.people.values()]


def test_a_class_of_moodle_from_its_archive_to_its_marks(
    project: Path, work: dict[str, bytes]
) -> None:
    """Graded, uploaded in the order told, corrected by hand, graded again, uploaded, purged."""
    moodle_site.php()
    to = site(project, work)
    line = command(f'make batch SUBMISSIONS="{ARCHIVE}" OUT=notes/')
    said = follow(line, project)
    out = project / "notes"
    filled = out / "moodle" / "Notes.csv"
    assert f"d'abord {filled} (séparateur : point-virgule), ensuite feedback.zip" in said
    to.upload(moodle_site.sheet(filled.read_bytes(), ";"))
    (pages,) = to.upload(moodle_site.files(out / "moodle" / "feedback.zip"))
    assert {number for people in pages.values() for number in people} == {"4001", "4002"}
    first = grades(to)
    assert first[0] is not None
    assert first[1] is not None
    assert first[0] > first[1] > 0
    assert first[2] is None

    (project / "Notes.csv").write_text(to.worksheet(";"), encoding="utf-8")
    by_hand = "who;override;reason\nZoé Lefèvre;14;oral examination\n"
    (project / "manual.csv").write_text(by_hand, encoding="utf-8")
    follow(line, project)
    assert "Zoé Lefèvre;2,25;14;saisie manuelle" in (out / "changes.csv").read_text(
        encoding="utf-8-sig"
    )
    to.upload(moodle_site.sheet(filled.read_bytes(), ";"))
    assert grades(to) == [first[0], 14, None]
    follow(command("make purge"), project)
    assert not out.exists()
    (project / "manual.csv").unlink()
    (project / "Notes.csv").unlink()


@contextmanager
def running(line: str, folder: Path) -> Iterator[None]:
    """Run a line of the page meanwhile."""
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    quiet = subprocess.DEVNULL
    process = subprocess.Popen(
        ["sh", "-c", line],
        cwd="/",
        env={**os.environ, "PATH": path, "TMPDIR": str(folder)},
        stdin=quiet,
        stdout=quiet,
        stderr=quiet,
        start_new_session=True,
    )
    try:
        yield
    finally:
        os.killpg(process.pid, signal.SIGTERM)
        process.wait(START_SECONDS)


def answers(port: int) -> bool:
    """Wait until somebody listens on a port."""
    for _ in range(10 * START_SECONDS):
        with socket.socket() as trying:
            if trying.connect_ex(("127.0.0.1", port)) == 0:
                return True
        time.sleep(0.1)
    return False


def test_the_cluster_as_the_page_says(
    project: Path, work: dict[str, bytes], tmp_path: Path
) -> None:
    """Its three commands, with a scheduler and a worker on this machine."""
    pytest.importorskip("distributed")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]

    def here(beginning: str) -> str:
        line = command(beginning).replace("/path/to/project", f"'{project}'")
        return line.replace("host:8786", f"127.0.0.1:{port}").replace("--nworkers 8", "")

    (project / "rendus").mkdir(exist_ok=True)
    for name, content in work.items():
        (project / "rendus" / f"{name}.zip").write_bytes(content)
    scheduler = f"{here('PYTHONPATH=/path/to/project dask scheduler')} --port {port} --no-dashboard"
    with running(scheduler, tmp_path):
        assert answers(port)
        with running(here("PYTHONPATH=/path/to/project dask worker"), tmp_path):
            follow(here("make batch SUBMISSIONS=rendus/ OUT=notes/ SCHEDULER="), project)
    assert {*marks(project / "notes")} == {*work}
    follow(command("make purge"), project)
