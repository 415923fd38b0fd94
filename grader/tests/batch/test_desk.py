"""OUT: whatever happens to it or to the batch, no result is lost and none is half there."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest

from grader import commands
from grader.batch import pool, results_folder
from grader.batch.records import BatchError, GradedFiles, Task
from grader.batch.results_folder import ResultsFolder, StoredResult
from grader.console.run import ExitCode
from grader.sandbox import bubblewrap
from grader.tests.batch import fake_grading

RESULTS = {
    **{"score": 1.0, "max_score": 2.0, "bonus": 0.0, "max_bonus": 0.0, "incomplete": False},
    **{"learnt": []},
    **{"tps": [], "exercises": [], "checks": [], "build": {"ok": True, "rejected": {}}},
}
PARTS = {"sources": "a"}


def bundle(score: float = 1.0, incomplete: bool = False) -> GradedFiles:
    """Return the result of a submission."""
    content = json.dumps({**RESULTS, "score": score}).encode()
    files = {"results.json": content, "report.html": b"<p>", "images/a.png": b"png"}
    return GradedFiles("ada", files, incomplete=incomplete)


def test_a_result_counts_only_with_its_state(tmp_path: Path) -> None:
    """Killed between the two writes, or with a file touched since: it is graded again."""
    with ResultsFolder(tmp_path / "out") as results:
        assert results.known("ada") is None
        results.save(bundle(1.0), PARTS)
        known = results.known("ada")
        assert known is not None
        assert (known.fresh, known.parts, known.summary["score"]) == (True, PARTS, 1.0)
        kept = (results.out / "state" / "ada.json").read_bytes()
        results.save(bundle(2.0), {"sources": "b"})
        (results.out / "state" / "ada.json").write_bytes(kept)  # as if killed before the state
        half = results.known("ada")
        assert half is not None
        assert half.fresh is False
        (results.out / "state" / "ada.json").write_text("{", encoding="utf-8")
        assert results.known("ada") is None


def test_an_incomplete_result_is_shown_and_not_kept(tmp_path: Path) -> None:
    """The next run tries again."""
    with ResultsFolder(tmp_path / "out") as results:
        results.save(bundle(incomplete=True), PARTS)
        assert (results.folder("ada") / "report.html").exists()
        assert results.known("ada") is None


def test_where_the_machine_fails_alone_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Each time at one submission while it grades the others: somebody is to look at it."""
    for name in ("Ada", "Eve", "Zoe"):
        (tmp_path / "in" / name).mkdir(parents=True)
        text = fake_grading.source(1, name)
        (tmp_path / "in" / name / "main.c").write_text(text, encoding="utf-8")
    fake_grading.use(monkeypatch, pages=False)
    graded = fake_grading.run

    def failing(tasks: Iterable[Task], *_: object) -> Iterator[GradedFiles]:
        for each in graded(tasks):
            yield GradedFiles("Eve", failure="gone") if each.name == "Eve" else each

    monkeypatch.setattr(pool, "run", failing)
    command = ["batch", str(tmp_path / "in"), "--out", str(tmp_path / "out"), "--lang", "en"]
    assert commands.main(command) == ExitCode.FAILED
    (line,) = [each for each in capsys.readouterr().out.splitlines() if "each time" in each]
    assert line.strip().startswith("Eve")
    assert "graded 2 others" in line


def test_a_class_takes_little_memory(tmp_path: Path) -> None:
    """All results name the same checks: what is kept of each has no names and rows of its own."""
    rows = [{"id": f"T.{k}", "outcome": "passed", "mistakes": []} for k in range(2)]
    points = {"points": 1.5, "max_points": 2.0}
    exercises = [{"id": f"T{k}", "outcome": "failed", **points} for k in range(2)]
    content = json.dumps({**RESULTS, "checks": rows, "exercises": exercises}).encode()
    with ResultsFolder(tmp_path / "out") as results:
        kept: list[StoredResult | None] = []
        for name in ("ada", "grace"):
            files = {"results.json": content, "report.html": b"<p>"}
            kept += [results.save(GradedFiles(name, files), PARTS), results.known(name)]
    checks = [each.summary["checks"] for each in kept if each]
    assert len({id(text) for each in checks for text in (*each, *each.values())}) == 3
    assert len(checks) == 4
    earned = [each.summary["exercises"] for each in kept if each]
    assert len({id(value) for each in earned for value in (*each, *each.values())}) == 3
    assert earned[0] == {"T0": ("failed", 1.5, 2.0), "T1": ("failed", 1.5, 2.0)}


def refusal(out: Path) -> str:
    """Return why a folder is not taken."""
    with pytest.raises(BatchError) as caught, ResultsFolder(out):
        pass
    return caught.value.key


def test_a_folder_that_is_not_ours_is_not_touched(tmp_path: Path) -> None:
    """Nor one in which another batch writes, nor a file, nor one that cannot be written."""
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "students").write_text("mine", encoding="utf-8")
    assert refusal(tmp_path / "thesis") == "batch.not_ours"
    assert commands.main(["purge", str(tmp_path / "thesis")]) == ExitCode.WRONG_USE
    assert (tmp_path / "thesis" / "students").read_text(encoding="utf-8") == "mine"
    with ResultsFolder(tmp_path / "out"):
        assert refusal(tmp_path / "out") == "batch.busy"
    (tmp_path / "file").touch()
    assert refusal(tmp_path / "file" / "out") == "batch.cannot_write"
    assert refusal(Path("/proc/out")) == "batch.cannot_write"


def test_a_place_that_submissions_see_is_not_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Below /usr, or beside the interpreter, others' work would lie open: one sentence."""
    (tmp_path / "in").mkdir()
    monkeypatch.setattr(bubblewrap, "_folders", lambda: (tmp_path / "system",))
    words = [str(tmp_path / "in"), "--out", str(tmp_path / "system" / "out"), "--lang", "fr"]
    assert commands.main(["batch", *words]) == ExitCode.WRONG_USE
    assert f"{tmp_path}/system/out est parmi les programmes du système" in capsys.readouterr().err
    assert not (tmp_path / "system").exists()


def test_out_that_disappears_ends_the_batch(tmp_path: Path) -> None:
    """One sentence, and nothing is made again elsewhere."""
    with ResultsFolder(tmp_path / "out") as results:
        shutil.rmtree(results.out)
        with pytest.raises(BatchError) as caught:
            results.save(bundle(), PARTS)
    assert caught.value.key == "batch.gone"


def test_a_full_disk_loses_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The file and the reason are told; what was there before is whole."""
    with ResultsFolder(tmp_path / "out") as results:
        results.save(bundle(1.0), PARTS)

        def full(path: Path, content: bytes) -> int:
            raise OSError(28, "No space left on device", str(path))

        with monkeypatch.context() as patch:
            patch.setattr(Path, "write_bytes", full)
            with pytest.raises(BatchError) as caught:
                results.save(bundle(2.0), {"sources": "b"})
        assert caught.value.key == "batch.cannot_write"
        assert caught.value.values["error"] == "No space left on device"
        known = results.known("ada")
        assert known is not None
        assert (known.fresh, known.summary["score"]) == (True, 1.0)


def test_purge_erases_the_batch_and_nothing_else(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Results and what was kept; a file that somebody put there stays, and is told."""
    with ResultsFolder(tmp_path / "out") as results:
        results.save(bundle(), PARTS)
    (tmp_path / "out" / "notes.txt").touch()
    assert commands.main(["purge", str(tmp_path / "out")]) == 0
    assert [each.name for each in (tmp_path / "out").iterdir()] == ["notes.txt"]
    assert "1 " in capsys.readouterr().out
    with ResultsFolder(tmp_path / "other"):
        pass
    assert commands.main(["purge", str(tmp_path / "other")]) == 0
    assert not (tmp_path / "other").exists()


def test_submissions_that_are_gone_leave_nothing_behind(tmp_path: Path) -> None:
    """Of who withdraws, no result is kept."""
    with ResultsFolder(tmp_path / "out") as results:
        results.save(bundle(), PARTS)
        results.forget_others({"bob"})
        left = list(results.out.rglob("*ada*"))
        assert left == []
    assert not os.path.exists(tmp_path / "out" / results_folder.WORK)
