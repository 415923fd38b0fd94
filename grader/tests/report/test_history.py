"""What changed since the last full run, and the file that knows it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from grader.course.texts import Texts
from grader.report import history
from grader.report.summary import Summary


def content(
    minute: int, *, name: str = "rendu", text: str = "", **outcomes: tuple[str, float]
) -> dict[str, Any]:
    """Return the content of results.json of a run at 10:MM; exercises as TP1_2=("failed", 1.5)."""
    rows = {key.replace("_", "."): outcome for key, outcome in outcomes.items()}
    return {
        "graded_at": f"2026-03-02T10:{minute:02}:00+01:00",
        "submission": {
            "name": name,
            "sources": [{"path": f"{name}/main.c"}],
            "files": {"main.c": text or str(minute)},
        },
        "score": sum(points for _, points in rows.values()),
        "max_score": 8,
        "bonus": 0,
        "partial": False,
        "incomplete": False,
        "exercises": [
            {"id": key, "outcome": outcome, "points": points}
            for key, (outcome, points) in rows.items()
        ],
        "changes": [],
        "same_files_as": "",
        "history": [],
    }


def said(folder: Path, run: dict[str, Any], language: str = "fr") -> list[str]:
    """Keep a run; return the sentences on what changed."""
    history.update(folder, run)
    return [text for text, _ in Summary(run, Texts(language)).changes()]


def test_what_passes_now_and_what_no_longer_does(tmp_path: Path) -> None:
    """Against the last full run; what broke earlier is told until it is mended."""
    first = content(30, TP2_4=("todo", 0), TP4_1=("passed", 7))
    assert said(tmp_path, first) == []
    assert said(tmp_path, content(42, TP2_4=("passed", 8), TP4_1=("failed", 2))) == [
        "TP2.4 est maintenant juste.",
        "TP4.1 n'est plus juste depuis 10:42 (dernière fois juste : 10:30).",
    ]
    assert said(tmp_path, content(50, TP2_4=("passed", 8), TP4_1=("crashed", 0))) == [
        "TP4.1 n'est plus juste depuis 10:42 (dernière fois juste : 10:30)."
    ]
    assert said(tmp_path, content(55, TP2_4=("passed", 8), TP4_1=("passed", 7)), "en") == [
        "TP4.1 is right now."
    ]


def test_points_that_move_are_told(tmp_path: Path) -> None:
    """Also of what was never right."""
    said(tmp_path, content(1, TP1_4=("failed", 1.5), TP1_5=("failed", 2)))
    assert said(tmp_path, content(2, TP1_4=("failed", 2.5), TP1_5=("failed", 1))) == [
        "TP1.4 : 1,5 points la dernière fois, 2,5 maintenant.",
        "TP1.5 : 2 points la dernière fois, 1 maintenant.",
    ]


def test_an_unsaved_file_is_guessed(tmp_path: Path) -> None:
    """The same files twice, and not all is right: perhaps the editor has the rest."""
    said(tmp_path, content(1, text="same", TP1_1=("failed", 0)))
    again = content(2, text="same", TP1_1=("failed", 0))
    assert said(tmp_path, again) == [
        "Vos fichiers sont exactement ceux de la dernière fois (10:01). Les avez-vous enregistrés ?"
    ]
    said(tmp_path, content(3, text="right", TP1_1=("passed", 2)))
    assert said(tmp_path, content(4, text="right", TP1_1=("passed", 2))) == []


def test_another_day_is_told_with_its_date(tmp_path: Path) -> None:
    """The hour alone would mislead."""
    said(tmp_path, content(30, TP1_1=("passed", 2)))
    late = {**content(42, TP1_1=("failed", 0)), "graded_at": "2026-03-04T09:00:00+01:00"}
    (text,) = said(tmp_path, late)
    assert text == "TP1.1 n'est plus juste depuis 09:00 (dernière fois juste : 02/03/2026, 10:30)."


@pytest.mark.parametrize("flag", ["partial", "incomplete"])
def test_partial_and_failed_runs_do_not_count(tmp_path: Path, flag: str) -> None:
    """Nothing is compared with them, and they are not kept."""
    said(tmp_path, content(1, TP1_1=("passed", 2)))
    assert said(tmp_path, {**content(2, TP1_1=("failed", 0)), flag: True}) == []
    assert [run["graded_at"][14:16] for run in history.read(tmp_path)] == ["01"]


def test_submissions_are_not_mixed(tmp_path: Path) -> None:
    """A run of another folder is no earlier run of this one."""
    said(tmp_path, content(1, name="reference", TP1_1=("passed", 2)))
    mine = content(2, TP1_1=("failed", 0))
    assert said(tmp_path, mine) == []
    assert [run["score"] for run in mine["history"]] == [0]


def test_the_file_stays_small(tmp_path: Path) -> None:
    """The oldest runs go."""
    for number in range(history.MOST + 5):
        history.update(tmp_path, content(number % 60, TP1_1=("failed", number)))
    runs = history.read(tmp_path)
    assert [run["score"] for run in runs] == [*range(5, history.MOST + 5)]


@pytest.mark.parametrize(
    "text",
    [
        *("", "{", "null", "[]", '{"schema": 2, "runs": []}', '{"schema": 1, "runs": [3]}'),
        '{"schema": 1, "runs": [{"submission": 1}]}',
        '{"schema": 1, "runs": 7}',
        "[" * 100_000,
    ],
)
def test_a_file_that_cannot_be_read_is_set_aside(tmp_path: Path, text: str) -> None:
    """Nothing is lost, and the run goes on with a new one."""
    (tmp_path / history.NAME).write_text(text, encoding="utf-8")
    assert said(tmp_path, content(1, TP1_1=("passed", 2))) == []
    assert (tmp_path / "history.unreadable").read_text(encoding="utf-8") == text
    assert len(history.read(tmp_path)) == 1


def test_malformed_exercises_are_set_aside_too(tmp_path: Path) -> None:
    """A run whose points are no numbers."""
    history.update(tmp_path, content(1, TP1_1=("passed", 2)))
    path = tmp_path / history.NAME
    data = json.loads(path.read_text(encoding="utf-8"))
    data["runs"][0]["exercises"]["TP1.1"]["points"] = "two"
    path.write_text(json.dumps(data), encoding="utf-8")
    assert history.read(tmp_path) == []
    assert (tmp_path / "history.unreadable").exists()


def test_a_partial_run_knows_what_the_last_full_one_found(tmp_path: Path) -> None:
    """By exercise, of the same submission; it is not kept itself."""
    history.update(tmp_path, content(30, TP2_4=("todo", 0), TP4_1=("passed", 7)))
    part = {**content(42, TP2_4=("passed", 8)), "partial": True}
    history.update(tmp_path / "partial", part)
    assert part["earlier"] == {"TP2.4": "todo", "TP4.1": "passed"}
    other = {**content(43, name="autre", TP2_4=("passed", 8)), "partial": True}
    history.update(tmp_path / "partial", other)
    assert "earlier" not in other
    assert [each["graded_at"][14:16] for each in history.read(tmp_path)] == ["30"]
    assert history.read(tmp_path / "partial") == []
