"""A class half of which is hostile: every honest mark is right, and little memory is taken."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

from grader.authoring.specimens import classroom
from grader.authoring.specimens.student import STUDENT_MAIN, main_c
from grader.course.exercises import ROOT
from grader.sandbox.levels import Level, best
from grader.tests.sandbox.hostile.test_marks import KILL, SHOUT
from grader.tests.support.sources import ENDLESS

MOST_MEGABYTES = 600  # of all the grader's own processes together, at their highest
HONEST = 6
TP1_POINTS = 15
LOOP = "for (volatile int k = 1; k;) { }"
NAP = "#include <unistd.h>\n__attribute__((constructor)) static void c(void) { usleep(7500000); }\n"


def lay(top: Path) -> None:
    """Write the class: honest ones, and those that take time, memory or the grader's patience."""
    for k in range(HONEST):
        folder = top / f"Honest {k}"
        classroom.first_tp(folder, {"extra.c": f"int own_{k};\n"})
    with zipfile.ZipFile(top / "Large.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("main.c", "int x;")
        for k in range(2500):
            archive.writestr(f"d{k}/x.c", b"/" * 999_999)
    with zipfile.ZipFile(top / "Bomb.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("raytracer.c", "int x;")
        archive.writestr("main.c", b" " * 300_000_000)
    with tarfile.open(top / "Date.tar.gz", "w:gz", format=tarfile.GNU_FORMAT) as tape:
        entry = tarfile.TarInfo("main.c")
        entry.mtime, entry.size = 10**15, 6
        tape.addfile(entry, io.BytesIO(b"int x;"))
    loops = main_c({**STUDENT_MAIN, **dict.fromkeys(STUDENT_MAIN, LOOP)})
    beside = {"Sleeps": NAP, "Shouts": SHOUT, "Kills": KILL, "Slow": ENDLESS}
    for name, text in beside.items():
        classroom.first_tp(top / name, {"beside.c": text})
    classroom.first_tp(top / "Loops", {"main.c": loops})
    classroom.first_tp(top / "Header", {"raytracer.h": ENDLESS})


def high_water(pid: int) -> int:
    """Return the most kilobytes that a process has had; 0 when it is gone."""
    try:
        text = Path(f"/proc/{pid}/status").read_text(encoding="utf-8")
        return int(text.partition("VmHWM:")[2].split()[0])
    except (OSError, IndexError):
        return 0


def workers(pid: int) -> list[int]:
    """Return the processes of the pool that the command has started."""
    found = []
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        for child in map(int, task.read_text(encoding="ascii").split()):
            try:
                words = Path(f"/proc/{child}/cmdline").read_bytes()
            except OSError:
                continue
            found += [child] if b"grader.batch.pool_worker" in words else []
    return found


@pytest.mark.exhaustive
def test_a_hostile_half_changes_nothing_for_the_other(tmp_path: Path) -> None:
    """Neither a mark, nor whether there is one; what is nobody's fault is never an error."""
    if best().level is not Level.STRONG:
        assert not os.environ.get("MRT_CI"), "CI must have bubblewrap"
        pytest.skip("bubblewrap is missing")
    lay(tmp_path / "in")
    words = [
        "batch",
        str(tmp_path / "in"),
        "--out",
        str(tmp_path / "out"),
        "--jobs",
        "2",
        "--public",
    ]
    peaks: dict[int, int] = {}
    with subprocess.Popen([sys.executable, "-m", "grader", *words], cwd=ROOT) as command:
        while True:
            for pid in (command.pid, *(workers(command.pid) if command.poll() is None else ())):
                peaks[pid] = max(peaks.get(pid, 0), high_water(pid))
            try:
                status = command.wait(0.1)
                break
            except subprocess.TimeoutExpired:
                continue
    assert status == 0
    assert len(peaks) >= 3
    assert sum(peaks.values()) < MOST_MEGABYTES * 1024
    scores = {
        path.parent.name: json.loads(path.read_text(encoding="utf-8"))["score"]
        for path in (tmp_path / "out" / "students").glob("*/results.json")
    }
    honest = {name: score for name, score in scores.items() if name.startswith("Honest")}
    assert honest == {f"Honest {k}": TP1_POINTS for k in range(HONEST)}
    others = {name: score for name, score in scores.items() if name not in honest}
    assert others == {
        **{"Large": 0, "Date": 0, "Shouts": 0, "Kills": 0, "Loops": 0, "Sleeps": 0},
        **{"Slow": TP1_POINTS, "Header": TP1_POINTS},
    }
