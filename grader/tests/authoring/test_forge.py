"""`make classroom`: the workflows of forges, run here step by step as a runner does."""

from __future__ import annotations

import base64
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml  # type: ignore[import-untyped]

from grader.authoring import forge
from grader.course import exercises
from grader.course.exercises import CORE, ROOT
from grader.course.texts import Texts
from grader.report import forge as shown
from grader.report.at_lines import Annotation
from grader.tests.report.test_terminal import check, content, exercise
from grader.tests.support.shell import run, script

GITHUB, GITLAB = forge.TEMPLATES
SCHEMAS = {GITHUB: "vendor.github-workflows", GITLAB: "vendor.gitlab-ci"}


@pytest.fixture(scope="module")
def template(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write the repository and make its first commit, in a folder whose name is hard."""
    folder = tmp_path_factory.mktemp("forge") / "l'été au labo"
    forge.write(folder, forge.repository("fr"))
    git(folder, "init", "--quiet")
    commit(folder)
    return folder


def git(folder: Path, *words: str) -> None:
    """Run git as nobody in particular."""
    names = ("-c", "user.name=a", "-c", "user.email=a@b.example", "-c", "core.autocrlf=false")
    subprocess.run(["git", *names, *words], cwd=folder, check=True, capture_output=True)


def commit(folder: Path) -> None:
    """Commit all that is there."""
    git(folder, "add", "--all", "--force")
    git(folder, "commit", "--quiet", "--message", "x")


@pytest.mark.long
@pytest.mark.parametrize("path", forge.TEMPLATES)
def test_a_workflow_is_one_for_its_forge(path: str, template: Path) -> None:
    """By the schema that is published for it."""
    words = ("-m", "check_jsonschema", "--builtin-schema", SCHEMAS[path], str(template / path))
    done = subprocess.run([sys.executable, *words], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def steps(folder: Path) -> Iterator[tuple[str, str]]:
    """Yield the commands of GitHub's workflow, by the names of their steps."""
    workflow = yaml.safe_load((folder / GITHUB).read_text(encoding="utf-8"))
    for step in workflow["jobs"]["grade"]["steps"]:
        if "run" in step:
            yield step["name"], step["run"]


def pushed(template: Path, folder: Path) -> tuple[dict[str, Any], str]:
    """Run the workflow on a student's repository; return the points and the job's summary."""
    script(folder.parent / "bin" / "apt-get", 'echo "$@" >>"$HOME/apt"')
    output, summary = folder.parent / "output", folder.parent / "summary"
    settings = {"HOME": str(folder.parent), "MRT_ENV": sys.prefix, "GITHUB_OUTPUT": str(output)}
    settings |= {"GITHUB_STEP_SUMMARY": str(summary), "PATH": f"{folder.parent / 'bin'}:{PATH}"}
    for name, command in steps(template):
        done = subprocess.run(
            ["bash", "-e", "-c", command],
            cwd=folder,
            env={**os.environ, **settings},
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, (name, done.stdout, done.stderr)
    (line,) = output.read_text(encoding="utf-8").splitlines()
    points = json.loads(base64.b64decode(line.removeprefix("result=")))
    return points, summary.read_text(encoding="utf-8")


PATH = os.environ["PATH"]


def handed_in(template: Path, place: Path, source: Path) -> Path:
    """Return a student's repository with the files of a folder in it."""
    folder = place / "dépôt"
    shutil.copytree(template, folder)
    for name in exercises.load().student:
        shutil.copyfile(source / name, folder / "core_c" / name)
    return folder


@pytest.mark.long
def test_a_push_of_nothing_has_no_points(template: Path, tmp_path: Path) -> None:
    """Each exercise is there, with a word in the summary; nothing fails."""
    folder = handed_in(template, tmp_path, CORE)
    points, summary = pushed(template, folder)
    judged = [each for each in exercises.load().exercises if each.checks]
    assert [each["name"].split(" ")[0] for each in points["tests"]] == [each.id for each in judged]
    assert (points["version"], points["status"], points["max_score"]) == (1, "fail", 120)
    assert sum(each["score"] for each in points["tests"]) == 0
    assert "| TP1.1 |" in summary


@pytest.mark.exhaustive
def test_a_hostile_push_has_the_points_of_its_code(template: Path, tmp_path: Path) -> None:
    """What a student changes beside the four files is as it was handed out again.

    Not the workflow itself: the forge has to protect it, as the instructors' page says.
    """
    folder = handed_in(template, tmp_path, ROOT / "reference")
    wrong = (folder / "core_c" / "main.c").read_text(encoding="utf-8")
    assert wrong.count("vector_init(1.f, 0.f, 0.f)") == 1
    wrong = wrong.replace("vector_init(1.f, 0.f, 0.f)", "vector_init(0.f, 1.f, 0.f)")
    (folder / "core_c" / "main.c").write_text(wrong, encoding="utf-8")
    for name in ("json.py", "grader/report/numpy.py", "sitecustomize.py"):
        (folder / name).write_text("raise SystemExit('forged')\n", encoding="utf-8")
    (folder / "GNUmakefile").write_text("grade:\n\techo forged\n", encoding="utf-8")
    (folder / "grader" / "course" / "exercises.toml").write_text("", encoding="utf-8")
    (folder / "core_c" / "scene.c").write_text("#error forged\n", encoding="utf-8")
    commit(folder)
    points, summary = pushed(template, folder)
    found = {each["name"].split(" ")[0]: each for each in points["tests"]}
    assert (found["TP1.1"]["status"], found["TP1.1"]["score"]) == ("fail", 0)
    assert (found["TP1.1"]["filename"], found["TP1.1"]["line_no"] > 1) == ("core_c/main.c", True)
    assert sum(each["score"] for each in points["tests"]) == 118
    assert "forged" not in summary


def test_a_summary_is_no_html_and_keeps_its_cells() -> None:
    """Whatever a message holds."""
    assert shown._cell("a | <b>\n`c`") == "a \\| &lt;b> 'c'"


def test_what_the_compiler_says_is_told_with_its_file() -> None:
    """It is about no exercise, so the file is its title."""
    said = Annotation("", "core_c/main.c", 3, True, "", "Il manque un point-virgule.")
    results = content((exercise(1, "failed", 0), [check(1, "failed")]))
    lines = shown.markdown(results, [said], Texts("fr")).splitlines()
    assert "- **core_c/main.c** (core_c/main.c:3) Il manque un point-virgule." in lines


def test_results_that_cannot_be_read_are_named(tmp_path: Path) -> None:
    """One line, with the command that makes them again."""
    done = run(sys.executable, "-m", "grader.report.forge", str(tmp_path / "no.json"), cwd=ROOT)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "no.json" in done.stderr
    assert "make grade" in done.stderr


def test_a_folder_that_holds_something_is_left_alone(tmp_path: Path) -> None:
    """One line names it; a file in the place of a folder too."""
    (tmp_path / "mine").write_text("x", encoding="utf-8")
    for path in (tmp_path, tmp_path / "mine"):
        done = run(*(sys.executable, "-m", "grader", "classroom", "--out", str(path)), cwd=ROOT)
        assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
        assert str(path) in done.stderr
    assert [*tmp_path.iterdir()] == [tmp_path / "mine"]
