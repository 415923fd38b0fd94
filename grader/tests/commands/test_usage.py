"""The command line's complaints and help, and which TPs are judged."""

from __future__ import annotations

import contextlib
import io
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from grader import commands
from grader.console.parser import complaint, tp_number
from grader.console.run import ExitCode
from grader.course import settings
from grader.course.texts import Texts
from grader.tests.support.judging import judge, solution


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["grade"], "Il manque : PATH."),
        (["grade", "x", "--tp", "deux"], "TP (--tp) ne peut pas être 'deux'."),
        (["grade", "x", "--tp"], "TP (--tp) demande une valeur."),
        (["grade", "x", "--hint", "9"], "HINT (--hint) ne peut pas être 9 ; au choix : 1, 2, 3."),
        (["grade", "x", "--nothing"], "Non compris : --nothing."),
        (["nothing"], "COMMANDE ne peut pas être 'nothing' ; au choix : 'grade'"),
    ],
)
def test_a_wrong_command_line_is_told_in_french(
    words: list[str],
    said: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """One line on stderr, which names what was typed, and 2."""
    monkeypatch.delenv("MRT_LANG", raising=False)
    with pytest.raises(SystemExit) as caught:
        commands.main(words)
    out, err = capsys.readouterr()
    assert (caught.value.code, out) == (2, "")
    assert err.replace("'", "").startswith(said.replace("'", ""))  # Pythons quote differently
    assert err.count("\n") == 1


def test_a_tp_is_named_by_its_number_or_its_name() -> None:
    """TP=TP2 is TP=2; what is neither is refused."""
    assert [tp_number(text) for text in ("2", "TP2", "tp2")] == [2, 2, 2]
    with pytest.raises(ValueError, match="deux"):
        tp_number("deux")


def test_the_help_speaks_the_language_asked_for(capsys: pytest.CaptureFixture[str]) -> None:
    """The headings and the options of argparse too."""
    for language, words in (
        ("fr", ["utilisation :", "affiche cette aide"]),
        ("en", ["shows this"]),
    ):
        with pytest.raises(SystemExit) as caught:
            commands.main(["grade", "--help", "--lang", language])
        out = capsys.readouterr().out
        assert caught.value.code == 0
        assert all(word in out for word in words)


def test_an_unknown_complaint_is_passed_on() -> None:
    """A Python to come may say things that we do not know."""
    assert complaint("something new", Texts("fr")) == "something new"


def test_a_tp_that_is_not_open_is_neither_judged_nor_counted(
    cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Unless the settings say so, or it is asked for."""
    only = settings.Course("fr", "c", (1,), count_closed=False)
    monkeypatch.setattr(settings, "load", lambda: only)
    keyword = "tp1.fill_red or tp5.reflectance"
    assert {each.tp for each in judge(solution(), cache, keyword=keyword).values()} == {1}
    assert {each.tp for each in judge(solution(), cache, 5, keyword).values()} == {5}
    every = settings.Course("fr", "c", (1,), count_closed=True)
    monkeypatch.setattr(settings, "load", lambda: every)
    assert {each.tp for each in judge(solution(), cache, keyword=keyword).values()} == {1, 5}


def test_a_full_disk_is_told_before_anything_is_compiled(
    submission: Callable[..., Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One sentence with the room that there is, and 3: the machine's fault."""
    usage = shutil.disk_usage(tmp_path)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage._replace(free=7_900_000))
    said = io.StringIO()
    with contextlib.redirect_stderr(said):
        words = ["grade", str(submission()), "--build", str(tmp_path / "not" / "there")]
        assert commands.main([*words, "--lang", "en"]) == ExitCode.FAILED
    assert said.getvalue().startswith(f"{tmp_path}: only 7 MB are left, and 50 are needed.")
    assert not (tmp_path / "not").exists()
