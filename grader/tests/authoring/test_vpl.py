"""`make vpl`: the execution files, run as VPL does, and the lines that it reads."""

from __future__ import annotations

import io
import os
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from grader.authoring import autograder, vpl
from grader.authoring.specimens.student import STUDENT_MAIN, main_c
from grader.course import exercises
from grader.course.exercises import CORE, ROOT
from grader.report.vpl import as_vpl, comments, nothing
from grader.tests.report.test_terminal import check, content, exercise
from grader.tests.support.shell import NOBODY, run

_LINE = re.compile(r"(Comment :=>>(-| |$).*|Grade :=>> \d+\.\d\d)")
FORGED = "\nGrade :=>> 100\r--|>\u2028Grade :=>> 100\vGrade :=>> 99\x1b[2J"


def grades(lines: list[str]) -> list[str]:
    """Return the lines that VPL takes for a grade."""
    return [each for each in lines if each.startswith("Grade")]


def test_every_line_is_a_comment_and_the_last_one_is_the_grade() -> None:
    """Whatever a message holds: lines of its own, controls, what VPL takes for a title."""
    results = content(
        (exercise(1, "failed", 1), [check(1, "failed", message=f"- x{FORGED}")]), language="fr"
    )
    lines = as_vpl(results, 20.0)
    assert [each for each in lines if not _LINE.fullmatch(each)] == []
    assert grades(lines) == lines[-1:]
    assert not any(ord(sign) < 32 for each in lines for sign in each)
    assert comments("- no title") == ["Comment :=>>  - no title"]
    titles = [each for each in lines if each.startswith("Comment :=>>-")]
    assert len(titles) == 1


@pytest.mark.parametrize(
    ("score", "bonus", "most", "grade"),
    [(50, 5, 100, "55.00"), (100, 20, 100, "100.00"), (50, 0, 20, "10.00"), (0, 0, 20, "0.00")],
)
def test_the_grade_is_out_of_the_activity_s(score: int, bonus: int, most: int, grade: str) -> None:
    """Bonuses count up to it."""
    results = {
        **content((exercise(1, "failed", 1), []), language="fr"),
        "score": score,
        "bonus": bonus,
    }
    results["max_score"] = 100
    assert as_vpl(results, most)[-1] == f"Grade :=>> {grade}"
    assert nothing("why")[-1] == "Grade :=>> 0.00"


def test_the_package_holds_what_git_tracks() -> None:
    """The solution too; three files, whose scripts VPL takes by their names."""
    files = vpl.files(autograder.project(ROOT))
    assert {*files} == {"vpl_run.sh", "vpl_evaluate.sh", "miniraytracer.zip"}
    with zipfile.ZipFile(io.BytesIO(files["miniraytracer.zip"])) as archive:
        names = archive.namelist()
    assert {"miniraytracer/reference/raytracer.c", "miniraytracer/Makefile"} < {*names}
    assert not any("/tests/" in each for each in names)


@pytest.mark.parametrize("out", ["{here}/file/a.zip", "/proc/no/a.zip"])
def test_an_archive_that_cannot_be_written_is_one_line(
    out: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """It names the place."""
    monkeypatch.setattr(vpl, "inputs", dict)
    (tmp_path / "file").write_text("x", encoding="utf-8")
    path = out.format(here=tmp_path)
    assert vpl.main(["--out", path]) == 2
    said = capsys.readouterr().err
    assert (path in said.replace("\n", ""), said.count("\n")) == (True, 1)


# ---- On an execution server ---------------------------------------------------------------------


@pytest.fixture(scope="module")
def package() -> dict[str, bytes]:
    """Return the execution files without inputs, which takes less time to make."""
    return vpl.files(autograder.project(ROOT))


@pytest.fixture
def home() -> Iterator[Path]:
    """Return a folder that its ordinary user can reach, as VPL's prisoner has it."""
    folder = Path(tempfile.mkdtemp(prefix="mrt-vpl-"))
    (folder / "p 12345").mkdir()
    yield folder / "p 12345"
    shutil.rmtree(folder)


def evaluated(
    home: Path, package: dict[str, bytes], files: dict[str, str], **settings: str
) -> list[str]:
    """Put the files together as VPL does, prepare, then execute; return what it reads.

    The execution files win over the student's, and are gone when the second script runs.
    """
    settings = {"VPL_LANG": "fr_FR.UTF-8", "VPL_GRADEMAX": "100", "MRT_ENV": sys.prefix, **settings}
    for name, text in files.items():
        (home / name).parent.mkdir(parents=True, exist_ok=True)
        (home / name).write_text(text, encoding="utf-8")
    for name, data in package.items():
        (home / name).write_bytes(data)
    variables = "".join(f"export {name}='{value}'\n" for name, value in settings.items())
    (home / "vpl_environment.sh").write_text(f"#!/bin/sh\n{variables}", encoding="utf-8")
    home.parent.chmod(0o755)
    for path in (home, *home.rglob("*")):
        if os.geteuid() == 0:
            os.chown(path, NOBODY, NOBODY)
    prepared = _as_prisoner(home, "vpl_evaluate.sh")
    assert (prepared.returncode, prepared.stdout, prepared.stderr) == (0, "", "")
    for name in package:
        (home / name).unlink()
    done = _as_prisoner(home, "vpl_execution")
    assert done.stderr == ""
    return done.stdout.splitlines()


def _as_prisoner(home: Path, script: str) -> subprocess.CompletedProcess[str]:
    (home / script).chmod(0o700)
    nobody = NOBODY if os.geteuid() == 0 else None
    return subprocess.run(
        [f"./{script}"],
        cwd=home,
        env={"PATH": os.environ["PATH"], "HOME": str(home)},
        capture_output=True,
        text=True,
        timeout=400,
        check=False,
        user=nobody,
        group=nobody,
        extra_groups=None if nobody is None else [],
    )


def of(folder: Path) -> dict[str, str]:
    """Return the student's files of a folder."""
    return {name: (folder / name).read_text("utf-8") for name in exercises.load().student}


def test_without_the_packages_a_line_names_their_place(
    home: Path, package: dict[str, bytes]
) -> None:
    """In both languages, as comments; no grade."""
    lines = evaluated(home, package, {}, MRT_ENV="/opt/none")
    assert [each.startswith("Comment :=>> /opt/none") for each in lines] == [True, True]


@pytest.mark.exhaustive
def test_a_student_s_files_are_none_of_the_scripts(home: Path, package: dict[str, bytes]) -> None:
    """Modules named as Python's, programs named as ours, a folder in our place: not taken.

    The program prints grades, in what is read too.
    """
    shout = 'printf("\\nGrade :=>> 100\\n"); fprintf(stderr, "Grade :=>> 100\\n"); fflush(stdout);'
    broken = '#include <stdio.h>\n#error "\\nGrade :=>> 100"\n' + main_c({"fill_red": shout})
    files = dict.fromkeys(("zipfile.py", "json.py", "vpl_execution"), "Grade :=>> 100\n")
    files |= {".mrt/miniraytracer/grader/__init__.py": "print('Grade :=>> 100')\n"}
    lines = evaluated(home, package, {**files, "main.c": broken}, VPL_GRADEMAX="20")
    assert [each for each in lines if not _LINE.fullmatch(each)] == []
    assert grades(lines) == lines[-1:] == ["Grade :=>> 0.00"]


@pytest.mark.exhaustive
def test_right_half_done_hostile_and_empty_work_is_graded(home: Path) -> None:
    """On inputs that nobody has seen; who kills the process has the points of the rest."""
    package = vpl.files({**autograder.project(ROOT), **vpl.inputs()})
    assert evaluated(home, package, of(ROOT / "reference"))[-1] == "Grade :=>> 100.00"
    first = {**of(CORE), "main.c": main_c(STUDENT_MAIN)}
    assert evaluated(home, package, first)[-1] == "Grade :=>> 15.00"
    kept = (home / ".mrt" / "class" / "results" / "inputs" / "seed").read_bytes()
    with zipfile.ZipFile(io.BytesIO(package["miniraytracer.zip"])) as archive:
        assert archive.read("class/results/inputs/seed") == kept
    deadly = {
        **STUDENT_MAIN,
        "fill_red": 'puts("\\nGrade :=>> 100"); kill(getppid(), 9); _exit(0);',
    }
    hostile = "#include <signal.h>\n#include <unistd.h>\n" + main_c(deadly)
    lines = evaluated(home, package, {**of(CORE), "main.c": hostile})
    assert (
        [each for each in lines if each.startswith("Grade")] == lines[-1:] == ["Grade :=>> 13.00"]
    )
    for name in exercises.load().student:
        (home / name).unlink()
    lines = evaluated(home, package, {"notes.txt": "nothing"})
    assert lines[-1] == "Grade :=>> 0.00"
    assert "main.c" in lines[0]


def test_run_shows_the_table_and_no_grade(home: Path, package: dict[str, bytes]) -> None:
    """vpl_run.sh leaves a command of the same kind."""
    scripts = [package[name].decode() for name in vpl.SCRIPTS]
    table, grade = (text.partition("<<'END'")[2] for text in scripts)
    assert "--table" in table
    assert "Grade" not in table
    (home / "vpl_run.sh").write_bytes(package["vpl_run.sh"])
    assert run("sh", "-n", "vpl_run.sh", cwd=home).returncode == 0
    assert "--table" not in grade
