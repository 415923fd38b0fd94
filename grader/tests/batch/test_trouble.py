"""What happens to a machine while a class is graded: told in a sentence, and nothing is lost."""

from __future__ import annotations

import itertools
import json
import os
import resource
import shutil
import subprocess
import time
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from grader.authoring.specimens import classroom
from grader.batch import command, pool
from grader.batch.grade_one import BuildFolder, grade
from grader.batch.results_folder import ResultsFolder, StoredResult
from grader.console.run import ExitCode
from grader.tests.batch.test_class import marks

UNLINKABLE = {"main.c": "int x = ;\n", "raytracer.c": "#error\n", "octree.c": "#error\n"}
GIGANTIC = 500_000_000
FAR = 4_102_444_800  # in 2100


def lay(top: Path, *names: str) -> Path:
    """Write submissions that are quick to grade, at nothing; return their folder."""
    for name in names:
        for file, text in UNLINKABLE.items():
            (top / "in" / name).mkdir(parents=True, exist_ok=True)
            (top / "in" / name / file).write_text(text, encoding="utf-8")
    return top / "in"


def batch(path: Path, out: Path) -> int:
    """Run the command here; what it builds is not shut in, since it is ours."""
    words = [str(path), "--out", str(out), "--isolation", "portable", "--yes", "--jobs", "1"]
    return command.main([*words, "--lang", "fr", "--public"])


def mounted(*words: str) -> bool:
    """Say whether a mount could be made or changed."""
    done = subprocess.run(["mount", *words], capture_output=True, timeout=20, check=False)
    return done.returncode == 0


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Path]:
    """Return a disk of 20 MB: OUT."""
    out = tmp_path / "out"
    out.mkdir()
    if os.geteuid() != 0 or not mounted("-t", "tmpfs", "-o", "size=20m", "tmpfs", str(out)):
        pytest.skip("only root can mount a disk")
    yield out
    subprocess.run(["umount", "-l", str(out)], timeout=20, check=True)


@pytest.mark.long
def test_a_full_and_a_read_only_disk(
    disk: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """No mark for want of room, then all of them; on a disk that is closed nothing changes."""
    submissions = lay(tmp_path, "Ada", "Grace")
    assert batch(submissions, disk) == ExitCode.FAILED
    said = capfd.readouterr()
    assert "No space left on device" in said.out
    assert "Traceback" not in said.err
    assert marks(disk) == {"Ada": [None], "Grace": [None]}
    assert mounted("-o", "remount,size=200m", str(disk))
    assert batch(submissions, disk) == ExitCode.DONE
    whole = (disk / "grades.csv").read_bytes()
    assert marks(disk) == {"Ada": [0], "Grace": [0]}
    assert mounted("-o", "remount,ro", str(disk))
    lay(tmp_path, "Linus")
    capfd.readouterr()
    assert batch(submissions, disk) == ExitCode.FAILED
    said = capfd.readouterr()
    assert f"{disk}/.batch.json.lock : écriture impossible" in said.err
    assert "Read-only file system" in said.err
    assert len(said.err.splitlines()) == 2  # behind what the level does not protect
    assert (disk / "grades.csv").read_bytes() == whole


@pytest.mark.long
def test_out_that_is_deleted_meanwhile(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """One sentence; nothing is made again in its place; the same command begins anew."""
    submissions, out = lay(tmp_path, "Ada", "Grace", "Linus"), tmp_path / "out"
    save = ResultsFolder.save

    def once(self: ResultsFolder, *words: object) -> StoredResult:
        known = save(self, *words)  # type: ignore[arg-type]
        shutil.rmtree(out)
        return known

    with monkeypatch.context() as patch:
        patch.setattr(ResultsFolder, "save", once)
        assert batch(submissions, out) == ExitCode.FAILED
    said = capfd.readouterr()
    assert f"{out} a disparu" in said.err
    assert "Traceback" not in said.err
    assert not out.exists()
    assert batch(submissions, out) == ExitCode.DONE
    assert marks(out) == {"Ada": [0], "Grace": [0], "Linus": [0]}


@pytest.mark.long
def test_submissions_of_500_mb(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Neither read into memory nor written to the disk; told; the others have their marks."""
    submissions, out = lay(tmp_path, "Ada", "Large file"), tmp_path / "out"
    for name in ("Large file/main.c", "Archive.zip", "Tape.tar.gz"):
        with (submissions / name).open("wb") as file:
            file.truncate(GIGANTIC)
    (submissions / "Bomb").mkdir()
    with zipfile.ZipFile(submissions / "Bomb" / "rendu.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        with archive.open("main.c", "w") as entry:
            for _ in range(GIGANTIC // 10_000_000):
                entry.write(b" " * 10_000_000)
        archive.writestr("raytracer.c", "#error\n")
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert batch(submissions, out) == ExitCode.DONE
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 100_000  # kilobytes
    assert marks(out) == {
        **{"Ada": [0], "Large file": [None], "Bomb": [None]},
        **{"Archive": [None], "Tape": [None]},
    }
    assert sum(each.stat().st_size for each in out.rglob("*") if each.is_file()) < 10_000_000
    said = capfd.readouterr()
    assert "Traceback" not in said.err
    assert "Tape : L'archive Tape est trop grosse : plus de 100 Mo" in said.out


@pytest.mark.long
@pytest.mark.skipif(os.geteuid() != 0, reason="only root becomes somebody else")
def test_root_without_a_sandbox(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """At level medium, in a folder that others cannot enter: code runs all the same, as nobody."""
    closed = tmp_path / "closed"
    closed.mkdir(mode=0o700)
    classroom.first_tp(closed / "in" / "Ada")
    out = closed / "out"
    temporary = pool._temporary
    made: list[Path] = []

    def noting(place: Path) -> Path:
        made.append(temporary(place))
        return made[-1]

    monkeypatch.setattr(pool, "_temporary", noting)
    words = [str(closed / "in"), "--out", str(out), "--isolation", "medium", "--jobs", "1"]
    assert command.main([*words, "--lang", "fr", "--public"]) == ExitCode.DONE
    assert marks(out) == {"Ada": [3.0]}
    results = json.loads((out / "students" / "Ada" / "results.json").read_text(encoding="utf-8"))
    assert results["isolation"] == "medium"
    assert [(closed in each.parents, each.exists()) for each in made] == [(False, False)]
    assert "Traceback" not in capfd.readouterr().err


@pytest.mark.long
def test_a_clock_that_jumps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """To 2100, to 1970 and back while two are graded: no deadline passes, and no mark changes."""
    submissions, out = lay(tmp_path, "Ada", "Grace"), tmp_path / "out"
    for name, moment in (("Ada", 0), ("Grace", FAR)):
        for file in (submissions / name).iterdir():
            os.utime(file, (moment, moment))
    clock = itertools.cycle([FAR, 0])
    monkeypatch.setattr(time, "time", lambda: float(next(clock)))
    # Here, since another process would have another clock.
    place = BuildFolder(tmp_path / "builds")
    place.folder.mkdir()
    monkeypatch.setattr(pool, "run", lambda tasks, *_: (grade(each, place) for each in tasks))
    assert batch(submissions, out) == ExitCode.DONE
    assert marks(out) == {"Ada": [0], "Grace": [0]}
    before = (out / "grades.csv").read_bytes()
    assert batch(submissions, out) == ExitCode.DONE
    assert (out / "grades.csv").read_bytes() == before
    assert not (out / "changes.csv").exists()
