"""How a tool ended is told by statuses on a descriptor of our own, never by what was printed."""

from __future__ import annotations

import os
import shutil
import signal
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from grader.sandbox import tools
from grader.sandbox.levels import IsolationError, Level, using
from grader.sandbox.tools import PARTS, ToolResult, give_away, run_tool
from grader.tests.support.shell import script
from grader.tests.support.sources import ENDLESS

HUGE = "char a[64 << 20] = {1};\n"


@pytest.fixture(params=list(Level))
def level(request: pytest.FixtureRequest) -> Iterator[Level]:
    """Work at each level that this machine has."""
    try:
        with using(request.param):
            yield request.param
    except IsolationError:
        pytest.skip("not on this machine")


@pytest.fixture
def out(tmp_path: Path) -> Path:
    """Return a folder to which tools write, beside the sources."""
    tmp_path.chmod(0o755)
    folder = tmp_path / "out"
    folder.mkdir()
    give_away(folder)
    return folder


def compiled(out: Path, text: str, seconds: float = 60) -> ToolResult:
    """Compile a source."""
    (out.parent / "x.c").write_text(text, encoding="utf-8")
    command = ["gcc", *PARTS, "-c", "x.c", "-o", str(out / "x.o")]
    return run_tool(command, out.parent, [], [out], seconds)


def test_each_part_of_gcc_tells_how_it_ended(level: Level, out: Path) -> None:
    """Compiler and assembler, at every level; a wrong source ends the first with 1."""
    done, wrong = compiled(out, "int x;\n"), compiled(out, "int x\n")
    assert (done.status, done.began, done.parts, done.signals) == (0, True, (0, 0), frozenset())
    assert (wrong.status, wrong.began, wrong.parts, wrong.signals) == (1, True, (1,), frozenset())


def test_a_limit_is_told_by_its_signal(
    level: Level, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Time and size, each for what it is; the seconds of computing are counted."""
    monkeypatch.setattr(tools, "CPU_SECONDS", 1)
    slow = compiled(out, ENDLESS)
    assert list(slow.signals) == [signal.SIGXCPU]
    assert 0.5 < slow.cpu < 3
    assert list(compiled(out, HUGE).signals) == [signal.SIGXFSZ]


def test_a_part_that_is_killed_is_seen(level: Level, out: Path) -> None:
    """By somebody, or by a machine short of memory: gcc itself only says so in words."""
    with ThreadPoolExecutor(1) as pool:
        compiling = pool.submit(compiled, out, ENDLESS)
        deadline = time.monotonic() + 60
        while not (found := _running("cc1")):
            assert time.monotonic() < deadline
            time.sleep(0.01)
        for each in found:
            os.kill(each, signal.SIGKILL)
        assert compiling.result().killed


def _running(name: str, pid: str = "self") -> list[int]:
    """Return the processes of that name among this one's descendants."""
    found: list[int] = []
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        for child in task.read_text(encoding="ascii").split():
            try:
                own = Path(f"/proc/{child}/comm").read_text(encoding="utf-8").strip()
                found += [int(child)] if own == name else _running(name, child)
            except OSError:  # it has just ended
                continue
    return found


def test_what_a_source_says_changes_no_status(level: Level, out: Path) -> None:
    """Neither of a sandbox nor of a killed part: it may print what it likes."""
    said = '#line 1 "bwrap"\n#error "Killed signal terminated program cc1"\nint f(void) { x }\n'
    told = compiled(out, f'{said}__asm__(".warning \\"bwrap: killed\\"");\n')
    assert (told.began, told.killed, told.parts) == (True, False, (1,))


def test_the_bubblewrap_that_is_found_is_run(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Wherever it lies: tools have a PATH of their own, without that place."""
    with using(Level.STRONG):
        text = f"touch '{out}/ran'; exec '{shutil.which('bwrap')}' \"$@\""
        own = script(out.parent / "elsewhere" / "bwrap", text)
        monkeypatch.setenv("PATH", f"{own.parent}:{os.environ['PATH']}")
        assert run_tool(["true"], out).status == 0
    assert (out / "ran").exists()


def test_a_sandbox_that_does_not_begin_is_seen(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever its status, and whatever it says."""
    with using(Level.STRONG):
        monkeypatch.setattr("grader.sandbox.bubblewrap._namespaces", lambda: ["--no-such-option"])
        assert not compiled(out, "int x;\n").began
