"""A class is judged on inputs that nobody has seen, made once, whole, and out of reach."""

from __future__ import annotations

import json
import os
import shutil
import stat
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from grader.batch import csv_table, fresh_inputs, grade_one, purge
from grader.batch.records import BatchError, Settings
from grader.checking.pictures.plan import judged
from grader.console.run import ExitCode
from grader.course import exercises
from grader.course.texts import Texts
from grader.sandbox import scratch
from grader.tests.batch.desk_class import Laid

FILE = "assignsubmission_file"
LEARNT = "Right on the inputs of the archive, wrong on others: TP2.1, TP5.1."


class Maker:
    """Stands for the process that makes the inputs; `act` is what happens in it."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.seeds: list[str] = []
        self.act: Callable[[Path], None] = lambda folder: None
        self.status, self.said = 0, ""
        monkeypatch.setattr(subprocess, "run", self._run)

    def _run(self, command: Sequence[str], **_: Any) -> subprocess.CompletedProcess[str]:
        folder = Path(command[command.index("--out") + 1])
        self.seeds.append(command[command.index("--seed") + 1])
        (folder / "manifest.json").write_text("{}", encoding="utf-8")
        self.act(folder)
        return subprocess.CompletedProcess(command, self.status, "", self.said)


@pytest.fixture
def maker(monkeypatch: pytest.MonkeyPatch) -> Maker:
    """Return what stands for the maker."""
    return Maker(monkeypatch)


def prepared(out: Path) -> tuple[int, Path]:
    """Prepare the inputs of a folder of results, as a batch does."""
    work = out / "work"
    work.mkdir(parents=True, exist_ok=True)
    return fresh_inputs.prepared(out, work)


def test_they_are_made_once_for_each_folder(tmp_path: Path, maker: Maker) -> None:
    """The second run finds them; another class has another seed."""
    first = prepared(tmp_path / "a")
    assert prepared(tmp_path / "a") == first
    other, _ = prepared(tmp_path / "b")
    assert maker.seeds == [str(first[0]), str(other)]
    assert other != first[0]


def test_a_making_that_was_stopped_leaves_nothing_half_made(tmp_path: Path, maker: Maker) -> None:
    """Killed in its middle, it is made anew from the same seed, and what was begun is not used."""

    def stop(folder: Path) -> None:
        (folder / "begun.npz").write_bytes(b"half")
        raise KeyboardInterrupt

    maker.act = stop
    with pytest.raises(KeyboardInterrupt):
        prepared(tmp_path)
    assert not (tmp_path / "inputs" / "data").exists()
    maker.act = lambda folder: None
    _, data = prepared(tmp_path)
    assert maker.seeds[0] == maker.seeds[1]
    assert sorted(each.name for each in data.iterdir()) == ["made_of", "manifest.json"]


def test_they_are_made_again_when_the_suites_change(
    tmp_path: Path, maker: Maker, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From the same seed; the old ones stay until the new ones are whole."""
    seed, data = prepared(tmp_path)
    (data / "old").touch()
    monkeypatch.setattr(fresh_inputs, "_key", lambda seed: f"others of {seed}")
    maker.status, maker.said = 1, "no room\n"
    with pytest.raises(BatchError):
        prepared(tmp_path)
    assert (data / "old").exists()
    maker.status = 0
    assert prepared(tmp_path) == (seed, data)
    assert not (data / "old").exists()


def test_the_seed_is_closed_to_others(tmp_path: Path, maker: Maker) -> None:
    """What runs as another user can neither list the folder nor open what is in it."""
    prepared(tmp_path)
    assert stat.S_IMODE(os.stat(tmp_path / "inputs").st_mode) == 0o700


@pytest.mark.parametrize("lang", ["fr", "en"])
def test_what_cannot_be_made_is_said_in_one_line(tmp_path: Path, maker: Maker, lang: str) -> None:
    """The line has the folder, the reason and the way round."""
    maker.status, maker.said = 2, "warning\n/x/data: No space left on device\n"
    with pytest.raises(BatchError) as caught:
        prepared(tmp_path)
    told = caught.value.sentence(Texts(lang))
    assert "\n" not in told
    assert "No space left" in told
    assert "PUBLIC=1" in told
    assert str(tmp_path) in told
    assert caught.value.code == ExitCode.FAILED


def test_a_folder_that_cannot_be_written_is_said_in_one_line(a_class: Laid) -> None:
    """Here a file stands where the inputs would be."""
    a_class.archive({f"Ada_1_{FILE}/main.c": "x"})
    assert a_class.run().status == ExitCode.DONE
    out = a_class.folder.parent / "out"
    shutil.rmtree(out / "inputs")
    (out / "inputs").touch()
    done = a_class.run()
    assert done.status == ExitCode.FAILED
    assert str(out / "inputs") in done.said
    assert len(done.said.strip().splitlines()) == 1


def test_another_machine_makes_its_own(
    tmp_path: Path, maker: Maker, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On a cluster the folder of the desk may not be there: the seed is, and once is enough."""
    monkeypatch.setattr(scratch, "own_folder", lambda: tmp_path)
    grade_one._made_here.cache_clear()
    away = Settings("fr", "strong", seed=5, fresh=str(tmp_path / "desk"))
    folder = grade_one._fresh(away)
    assert folder is not None
    assert (folder / "manifest.json").is_file()
    assert grade_one._fresh(replace(away, gallery=True)) == folder
    assert maker.seeds == ["5"]
    assert grade_one._fresh(Settings("fr", "strong")) is None
    grade_one._made_here.cache_clear()


@pytest.mark.long
def test_the_real_ones_are_other_inputs_of_the_same_suites(tmp_path: Path) -> None:
    """Every suite that the archive has, in other numbers; and every scene from elsewhere."""
    fresh_inputs.make(5, tmp_path / "made")
    found, public = (
        json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
        for folder in (tmp_path / "made", exercises.EXPECTED)
    )
    assert found["seed"] == 5
    assert found["files"].keys() == public["files"].keys()
    views = {path.name for path in (tmp_path / "made" / "views").iterdir()}
    assert {f"{each.name}.npz" for each in judged()} <= views
    same = [name for name, row in found["files"].items() if row == public["files"][name]]
    assert len(same) < len(found["files"]) / 10


def test_who_is_right_on_the_archive_alone_is_listed(a_class: Laid) -> None:
    """At the terminal, in grades.csv, and on the class page with names; never on the student's."""
    code = "/* worth 0.9 */ /* learnt TP2.1 */ /* learnt TP5.1 */"
    a_class.archive({f"Ada_1_{FILE}/main.c": code, f"Grace_2_{FILE}/main.c": "/* worth 1 */"})
    done = a_class.run("--names")
    assert done.said.count(LEARNT) == 1
    rows = csv_table.read(done.out / "grades.csv")
    remarks = csv_table.column(rows.header, ("remarks",))
    told = [LEARNT in cells[remarks] for cells in rows.rows]
    assert sorted(told) == [False, True]
    assert LEARNT in (done.out / "index.html").read_text(encoding="utf-8")
    for path in (done.out / "students").glob("*/report.html"):
        assert "archive" not in path.read_text(encoding="utf-8")


def expected_part(out: Path) -> str:
    """Return what a result of the class says of the data that it depends on."""
    (state,) = (out / "state").glob("*.json")
    return str(json.loads(state.read_text(encoding="utf-8"))["parts"]["expected"])


def test_the_archives_inputs_are_used_when_asked_for_and_told(a_class: Laid) -> None:
    """PUBLIC=1 makes nothing; changing one's mind grades again."""
    a_class.archive({f"Ada_1_{FILE}/main.c": "/* worth 1 */"})
    done = a_class.run("--public")
    assert "whoever has them has the answers too" in done.said
    assert not (done.out / "inputs").exists()
    public = expected_part(done.out)
    again = a_class.run()
    assert "whoever has them" not in again.said
    assert expected_part(again.out) != public == expected_part(a_class.run("--public").out)


def test_they_go_with_the_results(a_class: Laid) -> None:
    """`make purge` leaves nothing of them."""
    a_class.archive({f"Ada_1_{FILE}/main.c": "/* worth 1 */"})
    out = a_class.run().out
    assert (out / "inputs" / "data").is_dir()
    assert purge.main([str(out)]) == ExitCode.DONE
    assert not (out / "inputs").exists()
