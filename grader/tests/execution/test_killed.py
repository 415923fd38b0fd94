"""A process that is killed: from outside nobody pays for it; by itself, nothing is gained."""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from grader import commands
from grader.console.run import ExitCode
from grader.evaluation import attempts
from grader.execution.worker_process import Limits, SessionSocket, WorkerProcess
from grader.tests.support.outputs import outputs

Write = Callable[..., Path]
Start = Callable[
    [WorkerProcess, str, Limits], contextlib.AbstractContextManager[SessionSocket]
]  # a session
SUICIDE = "extern int kill(int, int), getpid(void); kill(getpid(), 9); (void)img;"


def graded(folder: Path, cache: Path, build: Path) -> dict[str, Any]:
    """Grade fill_red; return what its check has come to."""
    outputs(build, cache)
    words = ["grade", str(folder), "--tp", "1", "-k", "fill_red", "--build", str(build)]
    assert commands.main([*words, "--lang", "en"]) in (ExitCode.DONE, ExitCode.FAILED)
    content = json.loads((build / "grade" / "partial" / "results.json").read_text(encoding="utf-8"))
    check: dict[str, Any] = next(each for each in content["checks"] if "fill_red" in each["id"])
    return check


@pytest.fixture
def sessions(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return the libraries whose sessions were opened, as they are."""
    found: list[str] = []
    fork = WorkerProcess.fork

    @contextlib.contextmanager
    def noting(self: WorkerProcess, library: str, limits: Limits) -> Iterator[SessionSocket]:
        with fork(self, library, limits) as channel:
            found.append(library)
            yield channel

    monkeypatch.setattr(WorkerProcess, "fork", noting)
    return found


def kill_sessions(process: WorkerProcess) -> None:
    """Kill the processes that run the submission, from outside."""
    worker = process._control.pid()
    children = Path(f"/proc/{worker}/task/{worker}/children").read_text(encoding="ascii").split()
    assert children
    for each in children:
        os.kill(int(each), signal.SIGKILL)


def test_from_outside_it_is_run_again(
    submission: Write, cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Right code keeps its points; its process is killed in the first sessions, then no more."""
    turns = itertools.count()

    def killing(start: Start) -> Start:
        @contextlib.contextmanager
        def started(self: WorkerProcess, library: str, limits: Limits) -> Iterator[SessionSocket]:
            with start(self, library, limits) as channel:
                # The first holds constants; then one that serves several checks, and one's own.
                if next(turns) in (1, 2):
                    kill_sessions(self)
                yield channel

        return started

    for name in ("fork", "lend"):
        monkeypatch.setattr(WorkerProcess, name, killing(getattr(WorkerProcess, name)))
    check = graded(submission(), cache, tmp_path / "build")
    assert (check["outcome"], check["points"]) == ("passed", check["max_points"])
    assert next(turns) > 4


def test_by_itself_it_crashes_after_a_few_tries(
    submission: Write, cache: Path, tmp_path: Path, sessions: list[str]
) -> None:
    """It earns nothing, is told so, and is not run for ever."""
    check = graded(submission(fill_red=SUICIDE), cache, tmp_path / "build")
    assert (check["outcome"], check["points"]) == ("crashed", 0)
    assert "was killed (SIGKILL)" in check["message"]
    # fill, which the check needs, and the tables' sessions are among them.
    assert len(sessions) < 5 * attempts.TRIES


def test_a_machine_without_memory_is_no_crash(
    submission: Write, cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the kernel has killed for want of memory meanwhile, nothing is judged."""
    counts = itertools.count()
    monkeypatch.setattr(attempts, "out_of_memory", lambda: f"oom_kill {next(counts)}")
    check = graded(submission(fill_red=SUICIDE), cache, tmp_path / "build")
    assert check["outcome"] == "error"
    assert "short of memory" in check["message"]
