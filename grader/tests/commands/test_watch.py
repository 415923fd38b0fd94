"""`make watch`: graded again at each save."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import pytest

from grader.commands import watch
from grader.console.run import ExitCode


def test_each_save_is_graded_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """At once, then when a C file is another; what an editor has not finished is waited for.

    Nothing else in the folder counts.
    """
    source = tmp_path / "main.c"
    source.write_text("int a;", encoding="utf-8")
    saves = iter(["", "", "", "half", "whole", "", "", "image", ""])
    graded: list[str] = []

    def wait() -> None:
        step = next(saves, None)
        if step is None:
            raise KeyboardInterrupt
        if step == "image":
            (tmp_path / "image.ppm").write_bytes(b"P6")
        elif step:
            source.write_text(f"int {step};", encoding="utf-8")
            os.utime(source, ns=(len(step), len(step)))

    def grade(arguments: Sequence[str]) -> int:
        assert [*arguments] == [str(tmp_path), "--tp", "1"]
        graded.append(source.read_text(encoding="utf-8"))
        return ExitCode.DONE

    with pytest.raises(KeyboardInterrupt):
        watch.watch([str(tmp_path), "--tp", "1"], grade, wait)
    assert graded == ["int a;", "int whole;"]
    said = capsys.readouterr().out.splitlines()
    assert [each[:3] for each in said] == [watch.BEGINS, watch.ENDS] * 2


def test_a_wrong_use_is_told_once(tmp_path: Path) -> None:
    """It would be as wrong after the next save."""
    code = watch.watch([str(tmp_path)], lambda _: ExitCode.WRONG_USE, lambda: None)
    assert code == ExitCode.WRONG_USE
