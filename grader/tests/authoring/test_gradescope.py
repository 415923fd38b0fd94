"""`make gradescope`: the archive, its two scripts run as Gradescope does, and the results' form."""

from __future__ import annotations

import json
import os
import shutil
import stat
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonschema  # type: ignore[import-untyped]
import pytest

from grader.authoring import autograder, gradescope
from grader.authoring.autograder import AutograderError
from grader.authoring.specimens.student import STUDENT_MAIN, main_c
from grader.course import exercises
from grader.course.exercises import CORE, ROOT
from grader.files import zipped
from grader.report.gradescope import MAX_PICTURES, as_gradescope
from grader.tests.report.test_terminal import check, content, exercise
from grader.tests.support.shell import run, script

# What Gradescope's page on autograder specifications says of the fields that we use.
_OUTPUT = {
    "output": {"type": "string"},
    "output_format": {"enum": ["text", "html", "simple_format", "md", "ansi"]},
    "visibility": {"enum": ["hidden", "after_due_date", "after_published", "visible"]},
}
SCHEMA = {
    "type": "object",
    "required": ["score", "tests"],
    "additionalProperties": False,
    "properties": {
        **_OUTPUT,
        "score": {"type": "number"},
        "execution_time": {"type": "number", "minimum": 0},
        "stdout_visibility": _OUTPUT["visibility"],
        "tests": {
            "type": "array",
            "items": {
                "type": "object",
                "additionalProperties": False,
                "properties": {
                    **_OUTPUT,
                    "name": {"type": "string"},
                    "score": {"type": "number"},
                    "max_score": {"type": "number"},
                    "status": {"enum": ["passed", "failed"]},
                },
            },
        },
    },
}


def graded(images: Path) -> dict[str, Any]:
    """Return results with a picture that is wrong in every exercise but the last."""
    (images / "a.png").write_bytes(b"PNG")
    rows = [
        (
            exercise(number, "failed", 1),
            [
                check(number, "failed", name, images={"expected": "a.png", "got": "a.png"})
                for name in "abc"
            ],
        )
        for number in range(1, 7)
    ]
    last = [check(7, "passed", images={})]
    results = content(*rows, (exercise(7, "passed", 4), last), language="fr")
    for each in results["checks"]:
        each["seconds"] = 0.5
    return results


def test_results_have_the_documented_form(tmp_path: Path) -> None:
    """Points by exercise, no more pictures than a page may have, and nothing as HTML of its own."""
    results = graded(tmp_path)
    results["checks"][0]["message"] = "a < b\n<script>"
    told = as_gradescope(results, tmp_path)
    jsonschema.validate(told, SCHEMA)
    assert told["score"] == 10
    assert [each["status"] for each in told["tests"]] == ["failed"] * 6 + ["passed"]
    text = json.dumps(told)
    assert text.count("data:image/png") == MAX_PICTURES
    assert "<script>" not in text
    assert "a &lt; b<br>" in text


def test_the_archive_holds_what_git_tracks() -> None:
    """The solution too, and no tests; its scripts can be run."""
    files = gradescope.files(ROOT)
    assert {f"{autograder.TOP}/{name}" for name in ("reference/raytracer.c", "Makefile")} < {*files}
    assert not any("/tests/" in name for name in files)
    assert zipped(files) == zipped(dict(reversed(files.items())))


def test_where_there_is_no_repository_a_line_says_so(tmp_path: Path) -> None:
    """It names the folder."""
    with pytest.raises(AutograderError) as caught:
        gradescope.files(tmp_path)
    assert caught.value.values["path"] == tmp_path


@pytest.mark.parametrize("out", ["{here}/file/a.zip", "/proc/no/a.zip"])
def test_an_archive_that_cannot_be_written_is_one_line(out: str, tmp_path: Path) -> None:
    """It names the place."""
    (tmp_path / "file").write_text("x", encoding="utf-8")
    path = out.format(here=tmp_path)
    done = run(sys.executable, "-m", "grader", "gradescope", "--out", path, cwd=ROOT)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert path in done.stderr


# ---- In a container -----------------------------------------------------------------------------


@pytest.fixture(scope="module")
def container() -> Iterator[Path]:
    """Unpack the archive as Gradescope does, and run setup.sh: apt-get is played."""
    top = Path(tempfile.mkdtemp(prefix="mrt-gradescope-"))
    root = top / "auto grader"
    (top / "a.zip").write_bytes(zipped(gradescope.files(ROOT), executable=gradescope.SCRIPTS))
    with zipfile.ZipFile(top / "a.zip") as archive:
        archive.extractall(root / "source")
        for entry in archive.infolist():
            (root / "source" / entry.filename).chmod(stat.S_IMODE(entry.external_attr >> 16))
    (root / "results").mkdir()
    script(top / "bin" / "apt-get", "exit 0")
    done = played(root, "setup.sh")
    assert done.returncode == 0, done.stderr
    yield root
    shutil.rmtree(top)


def played(root: Path, name: str) -> subprocess.CompletedProcess[str]:
    """Run one of the scripts as Gradescope does."""
    path = f"{root.parent / 'bin'}:{os.environ['PATH']}"
    place = {"AUTOGRADER_ROOT": str(root), "MRT_ENV": sys.prefix, "PATH": path}
    return subprocess.run(
        [str(root / "source" / name)],
        env={**os.environ, **place},
        capture_output=True,
        text=True,
        check=False,
    )


def points(root: Path, files: dict[str, str]) -> dict[str, Any]:
    """Hand in files; return the results, which have the documented form."""
    shutil.rmtree(root / "submission", ignore_errors=True)
    (root / "submission").mkdir()
    for name, text in files.items():
        (root / "submission" / name).write_text(text, encoding="utf-8")
    done = played(root, "run_autograder")
    assert done.returncode == 0, done.stdout + done.stderr
    told: dict[str, Any] = json.loads((root / "results" / "results.json").read_text("utf-8"))
    jsonschema.validate(told, SCHEMA)
    return told


def of(folder: Path) -> dict[str, str]:
    """Return the student's files of a folder."""
    return {name: (folder / name).read_text("utf-8") for name in exercises.load().student}


@pytest.mark.exhaustive
def test_right_half_done_hostile_and_empty_work_is_graded(container: Path) -> None:
    """On inputs that nobody has seen; who kills the process has the points of the rest."""
    assert points(container, of(ROOT / "reference"))["score"] == 120
    first = {**of(CORE), "main.c": main_c(STUDENT_MAIN)}
    assert points(container, first)["score"] == 15
    deadly = {**STUDENT_MAIN, "fill_red": "kill(getppid(), 9); _exit(0);"}
    hostile = "#include <signal.h>\n#include <unistd.h>\n" + main_c(deadly)
    told = points(container, {**of(CORE), "main.c": hostile})
    assert (told["score"], told["tests"][0]["score"]) == (13, 0)
    told = points(container, {"notes.txt": "nothing"})
    assert (told["score"], told["tests"]) == (0, [])
    assert "main.c" in told["output"]
