"""What the bench of a class would see on the machine: each kind of thing that is left behind."""

from __future__ import annotations

import ctypes
import subprocess
from pathlib import Path

import pytest

from grader.authoring.bench import batch, snapshot
from grader.authoring.specimens.classroom import Pupil

PRIVATE, REMOVE = 0, 0  # of System V shared memory


def test_what_is_left_is_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A process, shared memory, a new, a changed and a lost file, and rights; then none of them."""
    monkeypatch.setattr(snapshot, "PLACES", ())
    for name in ("kept", "lost", "opened"):
        (tmp_path / name).write_text("1", encoding="ascii")

    def seen() -> list[str]:
        found = snapshot.differences(before, snapshot.take([tmp_path]))
        # The machine has other users.
        return [each for each in found if str(tmp_path) in each or "cat -" in each or "shm" in each]

    before = snapshot.take([tmp_path])
    assert seen() == []
    (tmp_path / "new").touch()
    (tmp_path / "kept").write_text("12", encoding="ascii")
    (tmp_path / "lost").unlink()
    (tmp_path / "opened").chmod(0o777)
    libc = ctypes.CDLL(None)
    shared = libc.shmget(PRIVATE, 4096, 0o600)
    with subprocess.Popen(["cat", "-"], stdin=subprocess.PIPE) as process:
        found = seen()
        process.kill()
    libc.shmctl(shared, REMOVE, None)
    assert f"+ shm {shared}" in found
    assert any(f"process {process.pid} " in each for each in found)
    assert [each for each in found if str(tmp_path) in each] == [
        f"+ {tmp_path / 'new'}",
        f"- {tmp_path / 'lost'}",
        f"~ {tmp_path / 'kept'}",
        f"~ {tmp_path / 'opened'}",
    ]


def test_goals_tell_every_wrong_mark(tmp_path: Path) -> None:
    """Whatever differs from what a pupil must get: another number, no line, one line too few."""
    header = "nom;rendu;note;points\n"
    rows = "a;right;3;3\nb;wrong;2,9;2,9\nc;pair;3;3\nd;none;;\n"
    (tmp_path / "grades.csv").write_text(header + rows, encoding="utf-8")
    pupils = [
        Pupil("right", "tp1", 15),
        Pupil("wrong", "tp1", 15),
        Pupil("pair", "pair", 15, ("c", "e")),
        Pupil("none", "empty", None),
        Pupil("absent", "tp1", 0),
    ]
    told = list(batch._wrong(pupils, tmp_path / "grades.csv"))
    assert [each.split(" ")[0] for each in told] == ["wrong", "pair", "absent"]
    found = batch.Class(200, 5, tuple(told), ("+ x",), 0.5, 1.0, 100.0, 2.0, {"tp1": 1.2})
    met = [each.met for each in batch.goals(found, found)]
    assert met == [False, False, True, True, True, True, True]
