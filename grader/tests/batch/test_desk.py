"""OUT: whatever happens to it or to the batch, no result is lost and none is half there."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path

import pytest

from grader import commands as cli
from grader.batch import results_folder as desks
from grader.batch.records import BatchError, Bundle
from grader.batch.results_folder import Desk, Known
from grader.sandbox import bubblewrap as bubble

RESULTS = {
    **{"score": 1.0, "max_score": 2.0, "bonus": 0.0, "max_bonus": 0.0, "incomplete": False},
    **{"tps": [], "exercises": [], "checks": [], "build": {"ok": True}},
}
PARTS = {"sources": "a"}


def bundle(score: float = 1.0, incomplete: bool = False) -> Bundle:
    """Return the result of a submission."""
    content = json.dumps({**RESULTS, "score": score}).encode()
    files = {"results.json": content, "report.html": b"<p>", "images/a.png": b"png"}
    return Bundle("ada", files, incomplete=incomplete)


def test_a_result_counts_only_with_its_state(tmp_path: Path) -> None:
    """Killed between the two writes, or with a file touched since: it is graded again."""
    with Desk(tmp_path / "out") as desk:
        assert desk.known("ada") is None
        desk.save(bundle(1.0), PARTS)
        known = desk.known("ada")
        assert known is not None
        assert (known.fresh, known.parts, known.summary["score"]) == (True, PARTS, 1.0)
        kept = (desk.out / "state" / "ada.json").read_bytes()
        desk.save(bundle(2.0), {"sources": "b"})
        (desk.out / "state" / "ada.json").write_bytes(kept)  # as if killed before the state
        half = desk.known("ada")
        assert half is not None
        assert half.fresh is False
        (desk.out / "state" / "ada.json").write_text("{", encoding="utf-8")
        assert desk.known("ada") is None


def test_an_incomplete_result_is_shown_and_not_kept(tmp_path: Path) -> None:
    """The next run tries again."""
    with Desk(tmp_path / "out") as desk:
        desk.save(bundle(incomplete=True), PARTS)
        assert (desk.folder("ada") / "report.html").exists()
        assert desk.known("ada") is None


def test_a_class_takes_little_memory(tmp_path: Path) -> None:
    """All results name the same checks: what is kept of each has no names and rows of its own."""
    rows = [{"id": f"T.{k}", "outcome": "passed", "mistakes": []} for k in range(2)]
    points = {"points": 1.5, "max_points": 2.0}
    exercises = [{"id": f"T{k}", "outcome": "failed", **points} for k in range(2)]
    content = json.dumps({**RESULTS, "checks": rows, "exercises": exercises}).encode()
    with Desk(tmp_path / "out") as desk:
        kept: list[Known | None] = []
        for name in ("ada", "grace"):
            files = {"results.json": content, "report.html": b"<p>"}
            kept += [desk.save(Bundle(name, files), PARTS), desk.known(name)]
    checks = [each.summary["checks"] for each in kept if each]
    assert len({id(text) for each in checks for text in (*each, *each.values())}) == 3
    assert len(checks) == 4
    earned = [each.summary["exercises"] for each in kept if each]
    assert len({id(value) for each in earned for value in (*each, *each.values())}) == 3
    assert earned[0] == {"T0": ("failed", 1.5, 2.0), "T1": ("failed", 1.5, 2.0)}


def refusal(out: Path) -> str:
    """Return why a folder is not taken."""
    with pytest.raises(BatchError) as caught, Desk(out):
        pass
    return caught.value.key


def test_a_folder_that_is_not_ours_is_not_touched(tmp_path: Path) -> None:
    """Nor one in which another batch writes, nor a file, nor one that cannot be written."""
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "students").write_text("mine", encoding="utf-8")
    assert refusal(tmp_path / "thesis") == "batch.not_ours"
    assert cli.main(["purge", str(tmp_path / "thesis")]) == cli.WRONG_USE
    assert (tmp_path / "thesis" / "students").read_text(encoding="utf-8") == "mine"
    with Desk(tmp_path / "out"):
        assert refusal(tmp_path / "out") == "batch.busy"
    (tmp_path / "file").touch()
    assert refusal(tmp_path / "file" / "out") == "batch.cannot_write"
    assert refusal(Path("/proc/out")) == "batch.cannot_write"


def test_a_place_that_submissions_see_is_not_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Below /usr, or beside the interpreter, others' work would lie open: one sentence."""
    (tmp_path / "in").mkdir()
    monkeypatch.setattr(bubble, "_folders", lambda: (tmp_path / "system",))
    words = [str(tmp_path / "in"), "--out", str(tmp_path / "system" / "out"), "--lang", "fr"]
    assert cli.main(["batch", *words]) == cli.WRONG_USE
    assert f"{tmp_path}/system/out est parmi les programmes du système" in capsys.readouterr().err
    assert not (tmp_path / "system").exists()


def test_out_that_disappears_ends_the_batch(tmp_path: Path) -> None:
    """One sentence, and nothing is made again elsewhere."""
    with Desk(tmp_path / "out") as desk:
        shutil.rmtree(desk.out)
        with pytest.raises(BatchError) as caught:
            desk.save(bundle(), PARTS)
    assert caught.value.key == "batch.gone"


def test_a_full_disk_loses_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The file and the reason are told; what was there before is whole."""
    with Desk(tmp_path / "out") as desk:
        desk.save(bundle(1.0), PARTS)

        def full(path: Path, content: bytes) -> int:
            raise OSError(28, "No space left on device", str(path))

        with monkeypatch.context() as patch:
            patch.setattr(Path, "write_bytes", full)
            with pytest.raises(BatchError) as caught:
                desk.save(bundle(2.0), {"sources": "b"})
        assert caught.value.key == "batch.cannot_write"
        assert caught.value.values["error"] == "No space left on device"
        known = desk.known("ada")
        assert known is not None
        assert (known.fresh, known.summary["score"]) == (True, 1.0)


def test_purge_erases_the_batch_and_nothing_else(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Results and what was kept; a file that somebody put there stays, and is told."""
    with Desk(tmp_path / "out") as desk:
        desk.save(bundle(), PARTS)
    (tmp_path / "out" / "notes.txt").touch()
    assert cli.main(["purge", str(tmp_path / "out")]) == 0
    assert [each.name for each in (tmp_path / "out").iterdir()] == ["notes.txt"]
    assert "1 " in capsys.readouterr().out
    with Desk(tmp_path / "other"):
        pass
    assert cli.main(["purge", str(tmp_path / "other")]) == 0
    assert not (tmp_path / "other").exists()


def test_submissions_that_are_gone_leave_nothing_behind(tmp_path: Path) -> None:
    """Of who withdraws, no result is kept."""
    with Desk(tmp_path / "out") as desk:
        desk.save(bundle(), PARTS)
        desk.forget_others({"bob"})
        left = list(desk.out.rglob("*ada*"))
        assert left == []
    assert not os.path.exists(tmp_path / "out" / desks.WORK)
