"""The report as text, from the content of results.json alone."""

from __future__ import annotations

import io
import re
from pathlib import Path
from typing import Any

import pytest

from grader import terminal
from grader.texts import Texts

PATH = Path("build/grade/results.json")


def exercise(number: int, outcome: str, points: float, **other: Any) -> dict[str, Any]:
    """Return an exercise of 4 points, as results.json has it."""
    names = {"id": f"TP1.{number}", "tp": 1, "function": f"f{number}", "file": "main.c"}
    rest = {"title": f"titre {number}", "bonus": False, "outcome": outcome}
    return {**names, **rest, "points": points, "max_points": 4, **other}


def check(number: int, outcome: str, name: str = "a", **other: str) -> dict[str, Any]:
    """Return a check of an exercise, as results.json has it."""
    names = {"id": f"tp1.f{number}.{name}", "exercise": f"TP1.{number}", "function": f"f{number}"}
    rest = {"title": f"ligne {name}", "outcome": outcome, "message": f"message {name}", "note": ""}
    return {**names, **rest, "hint": "Question ?", **other}


def content(*rows: tuple[dict[str, Any], list[dict[str, Any]]], **other: Any) -> dict[str, Any]:
    """Return the content of results.json with these exercises and checks."""
    exercises = [row for row, _ in rows]
    return {
        "submission": {"name": "rendu"},
        "notes": [],
        "build": {"ok": True, "warnings": [], "log": ""},
        "score": sum(each["points"] for each in exercises if not each["bonus"]),
        "max_score": sum(each["max_points"] for each in exercises if not each["bonus"]),
        "bonus": sum(each["points"] for each in exercises if each["bonus"]),
        "max_bonus": sum(each["max_points"] for each in exercises if each["bonus"]),
        "incomplete": False,
        "partial": False,
        "unjudged_tps": [5],
        "exercises": exercises,
        "checks": [each for _, checks in rows for each in checks],
        **other,
    }


def shown(report: dict[str, Any], language: str = "fr") -> list[str]:
    """Return the lines that are printed."""
    out = io.StringIO()
    terminal.show(report, PATH, Texts(language), out)
    return out.getvalue().splitlines()


def test_one_line_per_exercise_with_bars_and_totals() -> None:
    """Columns are aligned, decimals are French, bonuses stand apart."""
    lines = shown(
        content(
            (exercise(1, "passed", 4), [check(1, "passed")]),
            (exercise(2, "failed", 2.5), [check(2, "failed")]),
            (exercise(3, "todo", 0, bonus=True), [check(3, "todo")]),
        )
    )
    assert lines[2:6] == [
        "TP1 - Images",
        "  juste     TP1.1  titre 1  f1  ██████████  4 / 4",
        "  à revoir  TP1.2  titre 2  f2  ██████····  2,5 / 4",
        "  à faire   TP1.3  titre 3  f3  ··········  0 / 4 bonus",
    ]
    assert "Total provisoire : 6,5 / 8" in lines
    assert "Bonus : 0 / 4" in lines
    assert "TP5 : pas encore jugé par cette version du correcteur." in lines


def test_failures_are_explained_and_crashes_once() -> None:
    """Each failure has message and question; a function that crashes everywhere says so once."""
    rows = [check(1, "crashed", "a"), check(1, "crashed", "b"), check(1, "failed", "c")]
    lines = shown(content((exercise(1, "crashed", 0), rows)))
    assert "TP1.1 f1 - ligne a" in lines
    assert "TP1.1 f1 - ligne b" not in lines
    assert lines[lines.index("TP1.1 f1 - ligne c") + 1 :][:2] == ["  message c", "  Question ?"]


def test_the_next_step_is_the_first_that_can_be_done() -> None:
    """What is right or waits for something else is not the next step."""
    lines = shown(
        content(
            (exercise(1, "passed", 4), [check(1, "passed")]),
            (exercise(2, "blocked", 0), [check(2, "blocked", note="Attendre.")]),
            (exercise(3, "todo", 0), [check(3, "todo")]),
        )
    )
    assert "Prochaine étape : TP1.3, la fonction f3 dans main.c. Puis : make grade K=f3" in lines
    assert "TP1.2 - Attendre." in lines
    assert "Tout est encore à écrire : c'est le point de départ." not in lines


def test_a_long_compiler_log_is_cut() -> None:
    """The first messages are shown, and where the rest is; checks have nothing to add."""
    log = "".join(f"main.c:{k}: error\n" for k in range(40))
    build = {"ok": False, "warnings": ["main.c:1: warning: w", "note"], "log": log}
    lines = shown(content((exercise(1, "failed", 0), [check(1, "failed")]), build=build))
    assert lines[3:5] == ["  main.c:0: error", "  main.c:1: error"]
    assert "... et 10 lignes de plus dans build/grade/results.json" in lines
    assert "  main.c:1: warning: w" in lines
    assert "  message a" not in lines


def test_an_incomplete_or_partial_report_says_so() -> None:
    """Nobody takes it for a mark."""
    lines = shown(
        content((exercise(1, "error", 0), [check(1, "error")]), incomplete=True, partial=True), "en"
    )
    assert any(line.startswith("Incomplete report") for line in lines)
    assert any(line.startswith("Partial run") for line in lines)


def test_control_characters_of_a_submission_are_not_obeyed() -> None:
    """A file's name or a message cannot clear the screen or colour it."""
    lines = shown(content(submission={"name": "a\x1b[2Jb\rc"}))
    assert lines[0] == "Rendu : a�[2Jb�c"


def test_colours_change_nothing_of_the_text(monkeypatch: pytest.MonkeyPatch) -> None:
    """On a terminal the same lines come, with styles around them; what is to do has none."""
    report = content(
        (exercise(1, "crashed", 0), [check(1, "crashed")]),
        (exercise(2, "todo", 0), [check(2, "todo")]),
    )
    plain = shown(report)
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm")
    colored = shown(report)
    assert [re.sub(r"\x1b\[[\d;]*m", "", line) for line in colored] == plain
    assert colored[3] != plain[3]
    assert colored[4] == plain[4]
