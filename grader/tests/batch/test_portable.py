"""A class graded without a sandbox: what is said, what must be agreed to, what is cleaned."""

from __future__ import annotations

import contextlib
import io
import json
import os
import shutil
import sys
import tempfile
from pathlib import Path

import pytest

from grader.authoring.specimens import classroom
from grader.authoring.specimens.student import STUDENT_MAIN, main_c
from grader.batch import command
from grader.batch.records import BatchError
from grader.console.run import ExitCode
from grader.course.exercises import ROOT
from grader.course.texts import Texts
from grader.sandbox.leftovers import Leftovers
from grader.tests.support.shell import run

MARK = "mrt-left-behind-0451"
KEY = 0x4D525422
LEAVE = """
#define _GNU_SOURCE
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/msg.h>
#include <sys/sem.h>
#include <sys/shm.h>
#include <sys/stat.h>
#include <unistd.h>
void leave(void);
void leave(void) {
    int left = open("/tmp/@MARK@", O_CREAT | O_WRONLY, 0600) >= 0;
    left += open("/dev/shm/@MARK@", O_CREAT | O_WRONLY, 0600) >= 0;
    left += mkdir("/var/tmp/@MARK@", 0700) == 0;
    left += open("/var/tmp/@MARK@/more", O_CREAT | O_WRONLY, 0600) >= 0;
    left += shmget(@KEY@, 4096, IPC_CREAT | 0600) >= 0;
    left += semget(@KEY@, 1, IPC_CREAT | 0600) >= 0;
    left += msgget(@KEY@, IPC_CREAT | 0600) >= 0;
    printf("left %d\\n", left);
    if (fork() == 0) {
        setsid();
        if (fork() == 0) execlp("sleep", "sleep", "@SECONDS@", (char *)NULL);
        _exit(0);
    }
}
""".replace("@MARK@", MARK).replace("@KEY@", str(KEY))
PLACES = [Path(each, MARK) for each in ("/tmp", "/dev/shm", "/var/tmp")]


def shared() -> list[str]:
    """Return the kinds of System V objects that were left."""
    kinds = ("shm", "sem", "msg")
    return [each for each in kinds if str(KEY) in Path(f"/proc/sysvipc/{each}").read_text("ascii")]


def asleep(seconds: int) -> bool:
    """Whether a process that sleeps so long is there."""
    words = f"sleep\0{seconds}\0"
    for each in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            if each.read_text(encoding="utf-8") == words:
                return True
        except OSError:
            continue
    return False


def batch(folder: Path, *more: str) -> int:
    """Grade a class at that level."""
    words = [str(folder / "in"), "--out", str(folder / "out"), "--isolation", "portable"]
    return command.main([*words, "--lang", "en", "--jobs", "1", "--public", *more])


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder with a class of one, who leaves all that there is to be left."""
    body = {"fill_red": "extern void leave(void); leave(); (void)img;"}
    code = main_c({**STUDENT_MAIN, **body})
    seconds = str(10_000 + os.getpid())
    files = {"main.c": code, "leave.c": LEAVE.replace("@SECONDS@", seconds)}
    classroom.first_tp(tmp_path / "in" / "Eve", files)
    return tmp_path


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux" or os.geteuid() != 0, reason="of Linux, as root")
def test_what_submissions_leave_is_removed(folder: Path) -> None:
    """Files, folders, shared memory, queues and processes, of who runs as nobody."""
    assert batch(folder, "--yes") == ExitCode.DONE
    content = json.loads((folder / "out/students/Eve/results.json").read_text(encoding="utf-8"))
    # It runs once among others, is wrong, and once by itself, where the folder is there already.
    assert "left 6" in content["checks"][0]["output"]
    assert not any(each.exists() for each in PLACES)
    assert shared() == []
    assert not asleep(10_000 + os.getpid())


def test_nobody_who_agrees_means_nothing_is_graded(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is not protected is said; a script says --yes, a person types it."""
    monkeypatch.setattr(sys, "stdin", io.StringIO())
    assert batch(folder) == ExitCode.WRONG_USE
    said = capsys.readouterr().err
    assert "Marks can be forged" in said
    assert "YES=1" in said
    assert not (folder / "out").exists()


@pytest.mark.parametrize(("typed", "agreed"), [("yes\n", True), ("OUI\n", True), ("y\n", False)])
def test_a_person_types_it(monkeypatch: pytest.MonkeyPatch, typed: str, agreed: bool) -> None:
    """The whole word, in either language."""
    typing = io.StringIO(typed)
    monkeypatch.setattr(typing, "isatty", lambda: True)
    monkeypatch.setattr(sys, "stdin", typing)
    refused = pytest.raises(BatchError, match="portable_no")
    with contextlib.nullcontext() if agreed else refused:
        command._agree(False, Texts("en"))


ORDINARY = """
import ctypes, os, subprocess, sys
from pathlib import Path
from grader.sandbox.leftovers import Leftovers
make = "import ctypes; print(ctypes.CDLL(None).shmget(int(%r), 4096, 0o1600))"
mine = int(subprocess.check_output([sys.executable, "-c", make % "1380013090"]))
left = Leftovers(places=(sys.argv[1],))
ours = ctypes.CDLL(None).shmget(1380013091, 4096, 0o1600)
theirs = int(subprocess.check_output([sys.executable, "-c", make % "1380013092"]))
Path(sys.argv[1], "new").touch()
left.remove()
there = Path("/proc/sysvipc/shm").read_text().split()
print([str(each) in there for each in (mine, ours, theirs)], [each.name for each in left.files()])
for each in (mine, ours):
    ctypes.CDLL(None).shmctl(each, 0, None)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="of Linux")
def test_an_ordinary_user_s_own_is_left_alone() -> None:
    """Memory that was there before, or whose maker lives, stays; a file is told, not removed."""
    with tempfile.TemporaryDirectory(prefix="mrt-ordinary-") as name:
        top = Path(name)
        shutil.copytree(ROOT / "grader", top / "grader", ignore=shutil.ignore_patterns("tests"))
        (top / "open").mkdir()
        (top / "open").chmod(0o777)
        run("chmod", "-R", "a+rX", ".", cwd=top)
        words = [sys.executable, "-B", "-c", ORDINARY, str(top / "open")]
        done = run(*words, cwd=top, ordinary=True)
    assert done.stdout.splitlines() == ["[True, True, False] ['new']"], done.stderr
    assert Leftovers(places=()).files() == []
