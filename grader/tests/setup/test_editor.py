"""What the archive says to editors: tasks, a debugger, the flags of the C files."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from grader.commands import watch
from grader.course import exercises
from grader.course.exercises import CORE, ROOT
from grader.report.at_lines import Annotation

FLAGS = CORE / "compile_flags.txt"


def settings(name: str) -> Any:
    """Return a file of .vscode/."""
    return json.loads((ROOT / ".vscode" / f"{name}.json").read_text(encoding="utf-8"))


TASKS = settings("tasks")["tasks"]


def test_each_task_is_a_target_of_the_makefile() -> None:
    """With variables that its recipe reads."""
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for task in TASKS:
        assert task["command"] == "make"
        target, *variables = task["args"]
        recipe = re.search(rf"^{target}: ##.*\n((?:\t.*\n| +.*\n)+)", makefile, re.MULTILINE)
        assert recipe, target
        read = recipe[1] + (ROOT / "grader" / "setup" / "program.sh").read_text(encoding="utf-8")
        for each in variables:
            assert f"${{{each.split('=')[0]}:" in read.replace("$$", "$"), each


def test_the_exercises_to_choose_from_are_those_of_the_course() -> None:
    """Those that are judged, in order."""
    (asked,) = settings("tasks")["inputs"]
    rules = exercises.load()
    judged = [each for each in rules.exercises if each.checks]
    assert [each["value"] for each in asked["options"]] == [each.id for each in judged]
    assert [each["label"] for each in asked["options"]] == [
        f"{each.id} {each.functions[0]}" for each in judged
    ]


def matched(line: str) -> dict[str, str] | None:
    """Return what the problem matcher reads in a line."""
    pattern = TASKS[0]["problemMatcher"]["pattern"]
    found = re.match(pattern["regexp"], line)
    names = ("file", "line", "column", "severity", "message")
    return {name: found[pattern[name]] for name in names} if found else None


def test_the_problem_matcher_reads_our_lines_and_the_compilers() -> None:
    """All the tasks have the same one."""
    for is_error, severity in ((True, "error"), (False, "warning")):
        ours = Annotation("TP1.2", "core_c/main.c", 12, is_error, "TP1.2 fill", "Un : deux")
        assert matched(ours.for_editor()) == {
            **{"file": "core_c/main.c", "line": "12", "column": None},
            **{"severity": severity, "message": "TP1.2 fill - Un : deux"},
        }
    assert matched("TP1.2 fill - main.c, 12") is None
    assert len({json.dumps(each["problemMatcher"]["pattern"]) for each in TASKS}) == 1


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_the_problem_matcher_reads_a_real_error(compiler: str, tmp_path: Path) -> None:
    """As the compiler writes it."""
    if shutil.which(compiler) is None:
        pytest.skip(f"no {compiler} on this machine")
    (tmp_path / "main.c").write_text("int a;\nint b = c;\n", encoding="utf-8")
    words = [compiler, "-fsyntax-only", "main.c"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True)
    (found,) = filter(None, map(matched, done.stderr.splitlines()))
    assert (found["file"], found["line"], found["severity"]) == ("main.c", "2", "error")


def test_the_watching_task_knows_when_a_round_begins_and_ends() -> None:
    """By the words that `make watch` writes."""
    (task,) = [each for each in TASKS if each.get("isBackground")]
    background = task["problemMatcher"]["background"]
    assert background["beginsPattern"] == f"^{watch.BEGINS}"
    assert background["endsPattern"] == f"^{watch.ENDS}"


def test_the_debugger_starts_what_the_task_before_it_makes() -> None:
    """The program and the breakpoint are those of `make debug PREPARE=1`."""
    (launch,) = settings("launch")["configurations"]
    (task,) = [each for each in TASKS if each["label"] == launch["preLaunchTask"]]
    assert task["args"] == ["debug", "CASE=last", "PREPARE=1"]
    script = (ROOT / "grader" / "setup" / "program.sh").read_text(encoding="utf-8")
    for path in (launch["program"].split("/", 1)[1], "build/try/debugged.gdb"):
        assert f'"{path.replace("build/", "$BUILD/", 1)}"' in script
    assert "build/try/debugged.gdb" in launch["setupCommands"][0]["text"]


def test_clangd_has_the_flags_of_make_try() -> None:
    """The same standard and warnings, from a file that clang itself accepts."""
    flags = FLAGS.read_text(encoding="utf-8").split()
    script = (ROOT / "grader" / "setup" / "program.sh").read_text(encoding="utf-8")
    assert {*flags} - {"-xc"} <= {*re.findall(r'flags="(-std[^"]*)"', script)[0].split()}
    (folder,) = settings("c_cpp_properties")["configurations"]
    assert f"-std={folder['cStandard']}" in flags
    assert {*folder["compilerArgs"]} <= {*flags}
    clang = shutil.which("clang")
    if clang is None:
        pytest.skip("no clang on this machine")
    words = [clang, *flags, "-fsyntax-only", "-Werror=implicit", *map(str, CORE.glob("*.c"))]
    done = subprocess.run(words, cwd=CORE, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
