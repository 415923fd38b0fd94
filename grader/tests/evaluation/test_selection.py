"""K=: which checks a person means by a name."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

from grader.console.parser import UsageError
from grader.console.run import ExitCode
from grader.course import exercises as manifest
from grader.course import settings
from grader.course.texts import LANGUAGES, Texts
from grader.evaluation.records import PytestError
from grader.evaluation.selection import choose
from grader.tests.support.judging import judge, solution

RULES = manifest.load()


def whole(*exercises: str) -> set[str]:
    """Return every check of these exercises."""
    return {check.id for name in exercises for check in RULES.exercise(name).checks}


@pytest.mark.parametrize(
    ("keyword", "exercises"),
    [
        ("TP2.3", ["TP2.3"]),
        ("tp4.b1", ["TP4.B1"]),
        ("raytrace", ["TP2.2"]),  # with its picture, and nothing else: no folder, no file
        ("fill", ["TP1.2"]),
        ("shade", ["TP3.1"]),  # TP5.2 is written there too, later
        ("octree", ["TP4.B1"]),
        ("octree_free", ["TP4.B1"]),
        ("fill_color", ["TP1.2"]),
        ("plane", ["TP2.3"]),
        ("fill_red,fill_rect", ["TP1.1", "TP1.4"]),
        ("TP2.1 TP2.2", ["TP2.1", "TP2.2"]),
        ("draw fill_red", ["TP1.1"]),
    ],
)
def test_an_exercise_or_a_function_is_the_whole_exercise(
    keyword: str, exercises: list[str]
) -> None:
    """By its id, its function, what its checks are called by, or a part of these."""
    found = choose(RULES, None, keyword)
    assert found >= whole(*exercises)
    assert found == whole(*exercises)


def test_the_commands_of_the_contracts_judge_their_exercise() -> None:
    """What exercises.h prints below each contract means that exercise, whole."""
    text = (manifest.CORE / "exercises.h").read_text(encoding="utf-8")
    contract = r"/\* (TP\d\.B?\d) - (?:(?!\*/).)*?Check: make grade TP=(\d) K=(\w+)"
    printed = re.findall(contract, text, re.DOTALL)
    judged = {each.id for each in RULES.exercises if each.checks}
    assert {name for name, _, _ in printed} == judged
    for name, tp, keyword in printed:
        assert choose(RULES, int(tp), keyword) == whole(name), keyword


def test_a_tp_is_all_its_exercises() -> None:
    """K=TP3 is as TP=3."""
    assert choose(RULES, None, "TP3") == choose(RULES, 3, "") == choose(RULES, 3, "tp3")


def test_the_first_exercise_of_a_function_that_is_asked_for() -> None:
    """With TP=5 the one that is written in shade is another."""
    assert choose(RULES, 5, "shade") == whole("TP5.2")


@pytest.mark.parametrize(
    ("keyword", "checks"),
    [
        ("tp2.intersect_sphere.from_inside", {"tp2.intersect_sphere.from_inside"}),
        ("intersect_sphere.from_inside", {"tp2.intersect_sphere.from_inside"}),
        ("off_screen", {"tp1.fill_rect.off_screen", "tp1.fill_circle.off_screen"}),
        ("flat_0", {"tp2.scene.flat_0"}),
        ("flat_", {f"tp2.scene.flat_{scene}" for scene in (0, 1, 2, 4, 5)}),
    ],
)
def test_a_check_is_that_check(keyword: str, checks: set[str]) -> None:
    """By its whole id, the end of it, or a part."""
    assert choose(RULES, None, keyword) == checks


@pytest.mark.parametrize("keyword", ["miniraytracer", "grader", "test_tp2", "checks", "py", "zorg"])
def test_files_and_folders_have_no_say(keyword: str) -> None:
    """A word in the path of the workbook selects nothing; every function is listed, by TP."""
    with pytest.raises(UsageError) as caught:
        choose(RULES, None, keyword)
    assert caught.value.key == "usage.no_match"
    lines = str(caught.value.values["names"]).splitlines()
    assert [line.split()[0] for line in lines[1:]] == [f"TP{tp}" for tp in RULES.tps]
    listed = {name for line in lines[1:] for name in re.split(r"[ ,]+", line.strip())[1:]}
    assert listed == {name for each in RULES.exercises for name in each.functions}


def test_a_slip_is_given_the_name_that_was_meant() -> None:
    """A letter that is missing."""
    with pytest.raises(UsageError) as caught:
        choose(RULES, 2, "intersect_spere")
    assert caught.value.values["near"] == "intersect_sphere"
    for language in LANGUAGES:
        said = Texts(language).say(caught.value.key, **caught.value.values)
        assert "intersect_spere" in said
        assert " intersect_sphere" in said.partition("?")[0]


@pytest.mark.parametrize(
    ("tp", "keyword", "key"),
    [
        (None, "draw", "usage.no_checks"),  # judged by nobody: never "0 / 0"
        (2, "fill_red", "usage.other_tp"),
        (None, "fill_red or fill", "usage.bad_keyword"),
        (None, "not fill", "usage.bad_keyword"),
        (None, "fill_red zorg", "usage.no_match"),
    ],
)
def test_what_selects_nothing_says_why(tp: int | None, keyword: str, key: str) -> None:
    """One sentence in both languages, for each reason."""
    with pytest.raises(UsageError) as caught:
        choose(RULES, tp, keyword)
    assert caught.value.key == key
    for language in LANGUAGES:
        assert Texts(language).say(key, **caught.value.values)


def test_what_is_not_open_is_chosen_by_its_tp(monkeypatch: pytest.MonkeyPatch) -> None:
    """A name in a TP to come is told with the command that judges it all the same."""
    only = settings.Course("fr", "c", (1,), count_closed=False)
    monkeypatch.setattr(settings, "load", lambda: only)
    with pytest.raises(UsageError) as caught:
        choose(RULES, None, "reflectance")
    assert (caught.value.key, caught.value.values["tp"]) == ("usage.other_tp", 5)
    assert choose(RULES, 5, "reflectance") == whole("TP5.1")


def test_a_pytest_that_cannot_start_is_told(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In its own words, as a fault of the machine: not as a wrong choice of checks."""

    def failing(*_: object, **__: object) -> int:
        sys.stderr.write("no module named x")
        return int(pytest.ExitCode.USAGE_ERROR)

    monkeypatch.setattr(pytest, "main", failing)
    with pytest.raises(PytestError, match="no module named x") as caught:
        judge(solution(), cache, 1, chosen=["tp1.fill_red.every_pixel"])
    assert caught.value.code == ExitCode.FAILED


@pytest.mark.parametrize("name", ["PYTEST_ADDOPTS", "PYTEST_PLUGINS"])
def test_what_the_environment_asks_of_pytest_changes_no_mark(
    name: str, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A variable that a person has for pytest neither stops the checks nor leaves some out."""
    monkeypatch.setenv(name, "-x" if name == "PYTEST_ADDOPTS" else "no_such_plugin")
    found = judge(solution(), cache, 1, chosen=["tp1.fill_red.every_pixel"])
    assert {each.outcome.value for each in found.values()} == {"passed"}
