"""No variable that a program reads from the environment comes from a person: all are ours."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from grader.build import toolchain
from grader.course.exercises import ROOT
from grader.execution.session import open_core
from grader.sandbox import surroundings
from grader.sandbox.levels import IsolationError, Level, using
from grader.sandbox.tools import run_tool
from grader.tests.support.shell import run

# What the manuals list: gcc's "Environment Variables", ld(1), ld.so(8), GNU make's "Variables Used
# by Implicit Rules" and "MAKEFLAGS", the sanitizers' flags. bubblewrap's manual lists none.
MANUALS = {
    "gcc": (
        *("GCC_COLORS", "GCC_EXEC_PREFIX", "GCC_COMPARE_DEBUG", "GCC_EXTRA_DIAGNOSTIC_OUTPUT"),
        *("GCC_URLS", "COMPILER_PATH", "LIBRARY_PATH", "CPATH", "C_INCLUDE_PATH"),
        *("CPLUS_INCLUDE_PATH", "OBJC_INCLUDE_PATH", "DEPENDENCIES_OUTPUT"),
        *("SUNPRO_DEPENDENCIES", "SOURCE_DATE_EPOCH", "COLLECT_GCC_OPTIONS", "CCC_ADD_ARGS"),
    ),
    "ld": (
        *("GNUTARGET", "LDEMULATION", "LD_RUN_PATH", "COLLECT_NO_DEMANGLE"),
        *("LD_PRELOAD", "LD_AUDIT", "LD_BIND_NOW", "LD_BIND_NOT", "LD_DEBUG", "LD_DEBUG_OUTPUT"),
        *("LD_DYNAMIC_WEAK", "LD_HWCAP_MASK", "LD_ORIGIN_PATH", "LD_POINTER_GUARD", "LD_PROFILE"),
        *("LD_SHOW_AUXV", "LD_TRACE_LOADED_OBJECTS", "LD_USE_LOAD_BIAS", "LD_VERBOSE", "LD_WARN"),
        *("LD_PREFER_MAP_32BIT_EXEC", "GLIBC_TUNABLES"),
    ),
    "libc": ("MALLOC_ARENA_MAX", "MALLOC_CHECK_", "MALLOC_PERTURB_", "MALLOC_TRACE", "GCONV_PATH"),
    "make": ("MAKEFLAGS", "GNUMAKEFLAGS", "MFLAGS", "MAKEFILES", "MAKELEVEL", "MAKEOVERRIDES"),
    "sanitizers": (
        *("ASAN_OPTIONS", "UBSAN_OPTIONS", "LSAN_OPTIONS", "MSAN_OPTIONS", "TSAN_OPTIONS"),
        *("ASAN_SYMBOLIZER_PATH", "MSAN_SYMBOLIZER_PATH"),
    ),
}
# A person's own, which no list names, and which these programs read all the same.
OTHERS = {"HOME": "/poison", "LANG": "xx_XX", "LC_ALL": "xx_XX"}
POISON = "poison"


def names() -> set[str]:
    """Return all of them; Python and pytest list theirs themselves."""
    found = {name for each in MANUALS.values() for name in each}
    for command in (["--help-env"], ["--help"], ["-m", "pytest", "--help"]):
        done = subprocess.run(
            [sys.executable, *command], capture_output=True, text=True, timeout=60, check=False
        )
        found |= {*re.findall(r"\b(?:PYTHON|PYTEST_)[A-Z_]+\b", done.stdout)}
    return found


def poisoned() -> dict[str, str]:
    """Return an environment in which each of them is set."""
    return {**dict.fromkeys(names(), POISON), **OTHERS}


@pytest.fixture
def spoilt(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Set them all in this process, which has read its own long ago, and has `tmp_path`."""
    for name, value in poisoned().items():
        monkeypatch.setenv(name, value)


def test_each_that_is_documented_is_dropped() -> None:
    """But for a few, by which Python finds itself and the project, and writes."""
    kept = {name for name in names() if not surroundings.is_read(name)}
    assert kept <= {*surroundings._KEPT}
    assert len(names()) > 60


@pytest.fixture(params=list(Level))
def level(request: pytest.FixtureRequest) -> Iterator[Level]:
    """Work at each level that this machine has."""
    try:
        with using(request.param):
            yield request.param
    except IsolationError as error:
        pytest.skip(f"not on this machine: {error.best.reason}")


def test_a_tool_has_nothing_of_them(level: Level, spoilt: None, tmp_path: Path) -> None:
    """The compiler, the assembler and the linker: PATH, language, a folder for their files."""
    tmp_path.chmod(0o755)
    said = run_tool(["env"], tmp_path, writable=[tmp_path]).output
    assert POISON not in said
    assert {line.partition("=")[0] for line in said.splitlines()} <= {
        *("PATH", "LC_ALL", "TMPDIR", "PWD", "OLDPWD", "SHLVL", "_"),
    }


SPY = """
#include <stdio.h>
extern char **environ;
void spy(void);
void spy(void) {
    for (char **each = environ; *each; each++) printf("%s\\n", *each);
    fflush(stdout);
}
"""


def test_a_submission_has_nothing_of_them(
    level: Level, spoilt: None, submission: Callable[..., Path], cache: Path
) -> None:
    """While it runs, with sanitizers: theirs are ours."""
    folder = submission(fill_red="extern void spy(void); spy();", files={"spy.c": SPY})
    with open_core(folder, 96, 64, sanitized=True, cache=cache) as core, core.session() as session:
        session.call("fill_red", core.zeros("vec3", 96 * 64))
        said = session.output()
    assert POISON not in said
    assert {line.partition("=")[0] for line in said.splitlines()} <= {
        *("PATH", "PWD", "LC_ALL", "LC_CTYPE", "PYTHONPATH", "LD_PRELOAD"),
        *("ASAN_OPTIONS", "UBSAN_OPTIONS"),
    }


def test_a_compiler_that_is_asked_has_nothing_of_them(spoilt: None, tmp_path: Path) -> None:
    """Such as for its version, by whose words its flags are chosen."""
    asked = tmp_path / "asked"
    asked.write_text("#!/bin/sh\nenv\n", encoding="ascii")
    asked.chmod(0o755)
    assert POISON not in toolchain.ask([str(asked)], "--version")


# What of all that would break or change most, where it is read.
WORST = {
    "PYTHONOPTIMIZE": "2",
    "PYTHONWARNINGS": "error",
    "PYTHONINSPECT": "1",
    "PYTEST_ADDOPTS": "-x --no-such-option",
    "PYTEST_PLUGINS": "no_such_plugin",
    "ASAN_OPTIONS": "halt_on_error=0:detect_leaks=1",
    "GCC_EXEC_PREFIX": "/poison",
    "COMPILER_PATH": "/poison",
    "CPATH": "/poison",
    "LIBRARY_PATH": "/poison",
    "LD_RUN_PATH": "/poison",
    "GLIBC_TUNABLES": "glibc.malloc.check=3",
    "SOURCE_DATE_EPOCH": "0",
}


@pytest.mark.long
def test_a_mark_is_the_same_with_the_worst_of_them(tmp_path: Path) -> None:
    """A whole grade of TP1, from the command on: nothing missing, nothing on stderr."""
    words = ["grade", "reference", "--tp", "1", "--lang", "en", "--build", str(tmp_path)]
    done = run(
        sys.executable,
        "-m",
        "grader",
        *words,
        cwd=ROOT,
        ordinary=False,
        **{"HOME": str(tmp_path), **WORST},
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert "15 / 15" in done.stdout


def test_make_hands_nothing_of_python_s_on(tmp_path: Path) -> None:
    """But PYTHON, which says which one to use: what a person has for other work stays there."""
    makefile = f"{ROOT}/Makefile".replace(" ", "\\ ")  # one name for make, not two
    (tmp_path / "shown.mk").write_text(f"include {makefile}\nshown:\n\t@env\n", "utf-8")
    given: dict[str, str] = {
        "PYTHON": "/mine",
        "PYTHONPATH": "/poison",
        "PYTHONSAFEPATH": "1",
        "PYTHONHOME": "/x",
    }
    done = run("make", "-f", "shown.mk", "shown", cwd=tmp_path, ordinary=False, **given)
    handed = dict(line.partition("=")[::2] for line in done.stdout.splitlines())
    assert {name: handed.get(name) for name in given} == {
        **dict.fromkeys(given),
        "PYTHON": "/mine",
    }


def graded(tmp_path: Path, submission: Path, makeflags: str) -> tuple[int, str]:
    """Return status and words of `make grade TP=1` with such a MAKEFLAGS."""
    done = run(
        *("make", "grade", "TP=1", f"SUBMISSION={submission}", f"BUILD={tmp_path}"),
        cwd=ROOT,
        MAKEFLAGS=makeflags,
        MRT_ENV=sys.prefix,
        MRT_LANG="en",
    )
    return done.returncode, done.stdout + done.stderr


@pytest.mark.long
def test_no_option_of_make_s_changes_a_mark(tmp_path: Path) -> None:
    """Nor do all of them together, where make does what it is asked."""
    status, said = graded(tmp_path, ROOT / "reference", " -j8 -k -e -B -w -r -R -S")
    assert status == 0
    assert "15 / 15" in said


@pytest.mark.parametrize(("flag", "status"), [("k", 2), ("e", 2), ("i", 0), ("n", 0), ("t", 0)])
def test_three_options_of_make_s_change_the_status(tmp_path: Path, flag: str, status: int) -> None:
    """By which make is asked to pass over errors, or to do nothing; the page says which."""
    found, said = graded(tmp_path, tmp_path / "none", flag)
    assert found == status
    assert "/ 15" not in said
    page = (ROOT / "INSTRUCTORS.md").read_text(encoding="utf-8")
    assert (f"`-{flag}`" in page) == (status == 0)
