"""The levels of isolation: which one a machine gives, and what it tells when that is not enough."""

from __future__ import annotations

import io
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from grader.authoring.specimens import hostile
from grader.authoring.specimens.hostile import Quick
from grader.authoring.specimens.student import STUDENT_MAIN, main_c
from grader.build import sanitizer_guard, target
from grader.commands import main
from grader.course.exercises import ROOT
from grader.course.texts import LANGUAGES, Texts
from grader.execution import canary, crash_location
from grader.execution.session import Library, open_core
from grader.execution.worker_process import Limits, MachineError, start_worker
from grader.sandbox import bubblewrap, tools
from grader.sandbox.bubblewrap import sandbox
from grader.sandbox.levels import Isolation, IsolationError, Level, best, using
from grader.tests.support.shell import NOBODY
from grader.worker.syscalls import ARCHITECTURES

Write = Callable[..., Path]
# Where a call exists twice, for 32 bits and for 64, the name of the second ends so in the headers.
_NUMBER = re.compile(r"^#define __NR(?:3264)?_(\w+) (\d+)", re.MULTILINE)
_ALIAS = re.compile(r"^#define __NR_(\w+) __NR3264_(\w+)", re.MULTILINE)
PIXELS = np.zeros((96 * 64, 3), np.float32)


@pytest.fixture
def fresh() -> Iterator[None]:
    """Forget what was found out of this machine, before and after."""
    best.cache_clear()
    yield
    best.cache_clear()


def lacking(monkeypatch: pytest.MonkeyPatch, program: str) -> None:
    """Make a program disappear from the machine."""
    real = shutil.which
    monkeypatch.setattr(shutil, "which", lambda name: None if name == program else real(name))


def test_this_machine_is_strong_in_ci() -> None:
    """CI installs bubblewrap: what needs it must not be skipped there."""
    if os.environ.get("MRT_CI"):
        assert best() == Isolation(Level.STRONG)


HEADERS = {
    "x86_64": "/usr/include/*/asm/unistd_64.h",
    "aarch64": "/usr/include/asm-generic/unistd.h",
}


@pytest.mark.parametrize("machine", list(ARCHITECTURES))
def test_the_system_calls_have_the_kernel_s_numbers(machine: str) -> None:
    """As its own headers give them; those of another architecture are there as well."""
    found = list(Path("/").glob(HEADERS[machine][1:]))
    if not found and not os.environ.get("MRT_CI"):
        pytest.skip(f"no kernel headers for {machine} here")
    text = found[0].read_text(encoding="utf-8")
    numbers = {name: int(value) for name, value in _NUMBER.findall(text)}
    numbers |= {name: numbers[other] for name, other in _ALIAS.findall(text) if other in numbers}
    _, allowed, opens, *others = ARCHITECTURES[machine]
    tables = [allowed, {name: number for name, (number, _) in opens.items()}, *others]
    ours = {name: number for table in tables for name, number in table.items()}
    assert {name: numbers.get(name) for name in ours} == ours


@pytest.mark.skipif(sys.platform != "linux", reason="levels of Linux")
def test_without_bubblewrap_the_level_is_medium(
    fresh: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It still runs, and says what is missing; `strong` is refused with the mend."""
    lacking(monkeypatch, "bwrap")
    assert best() == Isolation(Level.MEDIUM, "isolation.no_bwrap")
    with pytest.raises(IsolationError) as caught, using(Level.STRONG):
        pass
    for language in LANGUAGES:
        assert "apt install bubblewrap" in caught.value.sentence(Texts(language))


def test_a_kernel_that_refuses_namespaces_is_told(
    fresh: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A bubblewrap that is there and does not start is not taken for isolation."""
    failing = ["sh", "-c", "echo no uid map >&2; exit 1"]
    monkeypatch.setattr("grader.sandbox.bubblewrap.sandbox", lambda *_: failing)
    assert best() == Isolation(Level.MEDIUM, "isolation.bwrap_fails", "no uid map")


@pytest.mark.parametrize(
    ("what", "value", "reason"),
    [("sys.platform", "darwin", "not_linux"), ("platform.machine", lambda: "mips", "architecture")],
)
def test_elsewhere_the_level_is_portable(
    fresh: None, monkeypatch: pytest.MonkeyPatch, what: str, value: object, reason: str
) -> None:
    """Another system or processor has limits only, and says why."""
    monkeypatch.setattr(f"grader.sandbox.levels.{what}", value)
    found = best()
    assert (found.level, found.reason) == (Level.PORTABLE, f"isolation.{reason}")


def test_every_reason_has_its_sentence() -> None:
    """In both languages, with its detail."""
    reasons = ["not_linux", "architecture", "no_setpriv", "no_bwrap", "bwrap_fails", "asked"]
    for language in LANGUAGES:
        for reason in reasons:
            assert Texts(language).say(f"isolation.{reason}", detail="x")


def test_the_command_line_refuses_to_go_below(
    fresh: None, monkeypatch: pytest.MonkeyPatch, submission: Write, tmp_path: Path
) -> None:
    """`--isolation strong` on a machine that cannot: exit code 3, with the mend, nothing graded."""
    lacking(monkeypatch, "bwrap")
    said = io.StringIO()
    arguments = ["grade", str(submission()), "--isolation", "strong", "--build", str(tmp_path)]
    with redirect_stderr(said):
        assert main(arguments) == 3
    assert "bubblewrap" in said.getvalue()
    assert not (tmp_path / "grade").exists()


def graded(folder: Path, level: Level, build: Path) -> dict[str, Any]:
    """Grade TP1 at a level; return results.json."""
    with redirect_stdout(io.StringIO()):
        arguments = ["grade", str(folder), "--tp", "1", "--isolation", level.value]
        assert main([*arguments, "--build", str(build)]) == 0
    path = build / "grade" / "partial" / "results.json"
    content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return content


def test_isolation_does_not_change_what_a_student_reads(submission: Write, cache: Path) -> None:
    """Wrong pixels, a write outside and an exit are told in the same words at every level."""
    folder = submission(
        fill="img[3] = c;", fill_red="img[WIDTH * HEIGHT].x = 1;", fill_rect="exit(3);"
    )
    told = [
        [
            (each["id"], each["outcome"], each["message"])
            for each in graded(folder, level, cache)["checks"]
        ]
        for level in Level
    ]
    assert told[0] == told[1] == told[2]
    assert "main.c:11" in told[0][0][2]


def test_a_sandbox_that_does_not_start_is_no_verdict(
    reference: Library, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is the machine's fault, and its own words are kept."""
    with using(Level.STRONG):
        monkeypatch.setattr("grader.sandbox.bubblewrap._namespaces", lambda: ["--no-such-option"])
        library = reference.library.library
        with start_worker() as process:
            process.declare(library, "int f(void);", sanitized=False)
            lost = pytest.raises(MachineError, match="no-such-option")
            with lost, process.fork(library, Limits()):
                pass


MEDIUM_REFUSES = ("reading.c", "leaving.c", "processes.c", "kernel.c")


def test_medium_refuses_without_namespaces(cache: Path, tmp_path: Path) -> None:
    """Seccomp and Landlock alone: files, processes, sockets and memory of others stay closed."""
    folder = hostile.write(tmp_path / "rendu", tmp_path / "secret", os.getpid())
    (tmp_path / "secret").write_text(hostile.SECRET_TEXT, encoding="ascii")
    names = hostile.attacks()
    sources = [
        (hostile.FOLDER / "run" / name).read_text(encoding="utf-8") for name in MEDIUM_REFUSES
    ]
    tried = [name for name in names if any(f"ATTACK({name})" in text for text in sources)]
    done = []
    with using(Level.MEDIUM), open_core(folder, 96, 64, cache=cache) as core:
        for name in tried:
            if hostile.ends_of(name):
                continue
            with core.session(Quick()) as session:
                arguments = (PIXELS, names.index(name), (0, 0, 0), (0, 0, 0))
                picture = session.call("fill_circle", *arguments).args["img"]
                done += [name] if picture[0, 0] == 1 else []
    assert done == []


def test_off_switches_are_found_where_they_count() -> None:
    """An attribute or a function of the runtime is named with its line; a comment is nothing."""
    code = (
        b"/* no_sanitize\n__asan_x */\nint a; // __ubsan_y\n__attribute__((no_sanitize)) int f;\n"
    )
    assert sanitizer_guard.in_text({"main.c": code}) == (
        "main.c:4:1: error: 'no_sanitize' switches the sanitizers off\n"
    )
    assert sanitizer_guard.in_text({"a.h": b'char *s = "__asan_default_options";'}) == ""


def test_an_off_switch_is_refused_with_a_sentence(submission: Write, cache: Path) -> None:
    """Even one whose name is pasted together: the compiled file tells."""
    paste = "#define P(a, b) a##b\nint P(__as, an_default_options)(void);\n"
    paste += "int P(__as, an_default_options)(void) { return 0; }\n"
    content = graded(submission(files={"extra.c": paste}), best().level, cache)
    assert "__asan_default_options" in content["build"]["log"]


def test_a_long_list_of_names_hides_no_off_switch(submission: Write, cache: Path) -> None:
    """More names than are read of a file: it is refused, whatever stands behind them."""
    ten = "".join(f"N@(k##{digit}) " for digit in range(10))
    names = f"#define N0(k) int {'A' * 60}##k;\n"
    names += "".join(f"#define N{k + 1}(k) {ten.replace('@', str(k))}\n" for k in range(4))
    assert target.SYMBOL_BYTES < 20_000 * 60
    paste = "#define P(a, b) a##b\nint P(__as, an_default_options)(void);\n"
    paste += "int P(__as, an_default_options)(void) { return 0; }\n"
    many = f"{names}N4(_1) N4(_2)\n{paste}"
    content = graded(submission(files={"extra.c": many}), best().level, cache)
    assert content["build"]["rejected"].keys() == {"extra.c"}
    assert "it defines too many names" in content["build"]["log"]
    fewer = graded(submission(files={"extra.c": f"{names}N3(_1)\n"}), best().level, cache)
    assert fewer["build"]["rejected"] == {}


# What ends calls, the linker, the assembler and the sanitizers with a message, each in its way.
SPEAKING = {
    "fill_red": "extern void abort(void); abort();",
    "fill": "extern void nowhere(void); nowhere();",
    "horizontal_gradient": "((char *)img)[-1] = 1;",
    "fill_rect": "extern int puts(const char *); puts(__FILE__ __BASE_FILE__); img[0].x = 1;",
    "fill_circle": "__builtin_trap();",
}
BROKEN = {
    "asm.c": '__asm__(".incbin \\"none\\"");',
    "included.c": '#include "none.h"',
    "pragma.c": '#pragma GCC dependency "none"',
    "linked.c": "int fill_red(void) { return 0; }",
}


@pytest.mark.parametrize("level", list(Level))
def test_no_place_of_the_machine_is_told(level: Level, tmp_path: Path, cache: Path) -> None:
    """By any message, at any level: neither where things are built nor where they run."""
    if level is Level.STRONG and best().level is not Level.STRONG:
        pytest.skip("bubblewrap is missing")
    folder = hostile.lay(tmp_path / "rendu", {"main.c": main_c({**STUDENT_MAIN, **SPEAKING})})
    for name, text in BROKEN.items():
        (folder / name).write_text(f"{text}\n", encoding="utf-8")
    content = graded(folder, level, cache)
    assert {each["outcome"] for each in content["checks"]} >= {"crashed"}
    assert content["build"]["rejected"].keys() == {"asm.c", "included.c", "pragma.c"}
    del content["submission"]["sources"]  # where the person's own files are
    said = json.dumps(content)
    assert "nowhere" in said
    for place in (tempfile.gettempdir(), str(tmp_path), str(cache), str(ROOT), "/mrt/"):
        assert place not in said


def test_tools_are_bounded(tmp_path: Path) -> None:
    """A tool that is missing, endless, or talks too much is told, stopped, or cut."""
    with pytest.raises(FileNotFoundError):
        tools.run_tool(["no-such-tool"], tmp_path)
    assert tools.run_tool(["sleep", "9"], tmp_path, seconds=0.3).status == tools.OUT_OF_TIME
    much = tools.run_tool(["seq", "1000000"], tmp_path)
    assert len(much.output) == tools.MAX_OUTPUT_BYTES


def test_a_place_that_is_none_is_not_invented(reference: Library) -> None:
    """Addresses outside the library, or none, give no place; and no error."""
    library = reference.library.library
    assert crash_location.locate(library, [-5, 0, 1 << 60]) == []
    said = "    #0 0x1  (elsewhere.so+0x12)\n    #1 0x1  (x+0xzz)\n"
    assert crash_location.from_report(library, said) == []


def test_the_project_is_hidden_inside() -> None:
    """The sandbox's command line names neither the project's folder nor a home."""
    words = sandbox([], [], {}, ["true"])
    assert str(Path(__file__).parents[3]) not in words
    assert "/proc" not in words


def test_the_canary_names_a_hole(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A sandbox that shows the whole machine is not taken for a strong one."""
    assert canary.main(["strong"]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == Texts("fr").say("isolation.proved")
    shared = (*bubblewrap._system(), "--bind", tempfile.gettempdir(), tempfile.gettempdir())
    monkeypatch.setattr("grader.sandbox.bubblewrap._system", lambda: shared)
    assert canary.main(["strong"]) == 1
    said = capsys.readouterr().out
    assert Texts("fr").say("canary.include") in said
    assert Texts("fr").say("canary.read") in said


GUARDED = """
import os, subprocess, sys
from grader.sandbox import orphans
orphans.guard()
spy = "import os; open(f'/proc/{os.getppid()}/mem', 'rb')"
spied = subprocess.run([sys.executable, "-c", spy], capture_output=True, text=True)
print(spied.stderr.strip().rpartition(chr(10))[2].partition(":")[0])
leave = "import os, time; os.fork() and os._exit(0); os.setsid(); os.fork() and os._exit(0);"
said = subprocess.Popen(
    [sys.executable, "-c", leave + "print(os.getpid(), flush=True); time.sleep(60)"],
    stdout=subprocess.PIPE, text=True,
)
left = int(said.stdout.readline())
said.wait()
orphans.sweep()
print(orphans._children(), os.path.exists(f"/proc/{left}"))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="of Linux")
def test_the_grader_s_process_is_closed_and_sweeps() -> None:
    """Nobody of its own user opens its memory; a daemon that a child left is ended with it."""
    ordinary: dict[str, Any] = {}
    with tempfile.TemporaryDirectory(prefix="mrt-ordinary-") as name:
        shutil.copytree(ROOT / "grader", f"{name}/grader", ignore=shutil.ignore_patterns("tests"))
        if os.geteuid() == 0:  # to whom nothing is closed
            ordinary = {"user": NOBODY, "group": NOBODY, "extra_groups": []}
            subprocess.run(["chmod", "-R", "a+rX", name], check=True, timeout=60)
        done = subprocess.run(
            [sys.executable, "-B", "-c", GUARDED],
            cwd=name,
            stdout=subprocess.PIPE,
            text=True,
            timeout=60,
            check=True,
            **ordinary,
        )
    assert done.stdout.splitlines() == ["PermissionError", "set() False"]
