"""`make watch`: graded again at each save."""

from __future__ import annotations

import io
import os
import signal
import sys
import time
from argparse import Namespace
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from grader import commands
from grader.commands import sketch, watch
from grader.console.run import ExitCode
from grader.course import exercises
from grader.course.sizes import UNIT
from grader.course.texts import Texts
from grader.execution.libraries import Libraries
from grader.intake.submission import read_submission
from grader.sandbox import orphans
from grader.tests.support.outputs import outputs

FRENCH = Texts("fr")
ROOT = exercises.ROOT


def saving(source: Path, steps: Sequence[str]) -> Callable[[float], None]:
    """Return a wait after each of which a file has another text; "" leaves it as it is."""
    left = iter(enumerate(steps, 1))

    def wait(_: float) -> None:
        number, text = next(left, (0, ""))
        if not number:
            raise KeyboardInterrupt
        if text:
            source.write_text(text, encoding="utf-8")
            os.utime(source, ns=(number, number))

    return wait


def test_each_save_is_graded_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """At once, then when a C file is another; what an editor has not finished is waited for.

    Nothing else in the folder counts.
    """
    source, graded = tmp_path / "main.c", list[str]()
    source.write_text("int a;", encoding="utf-8")
    (tmp_path / "image.ppm").write_bytes(b"P6")

    def grade(arguments: Sequence[str]) -> int:
        assert [*arguments] == [str(tmp_path), "--tp", "1", "--sketch"]
        graded.append(source.read_text(encoding="utf-8"))
        return ExitCode.DONE

    wait = saving(source, ["", "", "", "int half", "int whole;", "", "", ""])
    with pytest.raises(KeyboardInterrupt):
        watch.watch([str(tmp_path), "--tp", "1"], grade, wait, FRENCH)
    assert graded == ["int a;", "int whole;"]
    said = capsys.readouterr().out.splitlines()
    assert [each[:3] for each in said] == [watch.BEGINS, watch.ENDS] * 2


def test_a_wrong_use_is_told_once(tmp_path: Path) -> None:
    """It would be as wrong after the next save."""
    code = watch.watch([str(tmp_path)], lambda _: ExitCode.WRONG_USE, lambda _: None, FRENCH)
    assert code == ExitCode.WRONG_USE


def test_what_was_saved_meanwhile_comes_before_the_rest(tmp_path: Path) -> None:
    """The rest of a round would judge what is past: the next round begins."""
    source = tmp_path / "main.c"
    source.write_text("int a;", encoding="utf-8")
    first, second = (f"void fill_red(void) {{ {each}; }}" for each in ("a", "b"))
    wait = saving(source, ["", first, "", "", "", "", ""])
    rounds: list[tuple[str, Sequence[str]]] = []

    def grade(arguments: Sequence[str]) -> int:
        text = source.read_text(encoding="utf-8")
        rounds.append((text, arguments[1:]))
        if text == first:
            source.write_text(second, encoding="utf-8")
        return ExitCode.DONE

    with pytest.raises(KeyboardInterrupt):
        watch.watch([str(tmp_path)], grade, wait, FRENCH)
    changed = ["-k", "TP1.1", "--brief", "--sketch"]
    assert rounds == [("int a;", ["--sketch"]), (first, changed), (second, changed), (second, [])]


CHANGED = "/* more */ color texture_color(void) { return a; }\nbool in_shadow(void) { return b; }"


@pytest.mark.parametrize(
    ("now", "settings", "added"),
    [
        (CHANGED.replace("a;", "c;"), {}, [["-k", "TP3.B2", "--brief", "--sketch"], []]),
        (CHANGED.replace("b;", "c;"), {"tp": 4}, [["-k", "TP4.1", "--brief", "--sketch"], []]),
        (CHANGED.replace("b;", "c;"), {"tp": 3}, [["--sketch"]]),
        (CHANGED.replace("b;", "c;"), {"keyword": "in_shadow"}, [["--sketch"]]),
        (CHANGED.replace("b;", "/* b */  b;"), {}, [["--sketch"]]),
        ("#define N 2\n" + CHANGED, {}, [["--sketch"]]),
    ],
    ids=["one", "of this TP", "of another TP", "asked for by name", "a comment", "a define"],
)
def test_what_changed_comes_first(now: str, settings: dict[str, object], added: object) -> None:
    """The exercises of the changed functions; all at once when there are none, or by name."""
    options = Namespace(**{"tp": None, "keyword": ""} | settings)
    before, after = ({"raytracer.c": each} for each in (CHANGED, now))
    assert [*watch.rounds(options, before, after)] == added


@pytest.fixture
def warmed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Skip where no grade is made by a fork; no child is one of another test's."""
    if not sys.platform.startswith("linux"):
        pytest.skip("grades are processes of their own here")
    # A process of tests has other children.
    monkeypatch.setattr(orphans, "sweep", lambda: None)
    monkeypatch.setattr(orphans, "guard", lambda: None)
    watch.warm(FRENCH)


def folder_of(tmp_path: Path, edit: tuple[str, str] = ("", "")) -> Path:
    """Return a folder of the reference's files, with an edit of raytracer.c."""
    folder = tmp_path / "rendu"
    folder.mkdir()
    for name in exercises.load().student:
        text = (ROOT / "reference" / name).read_text(encoding="utf-8")
        assert name != "raytracer.c" or edit[0] in text
        (folder / name).write_text(text.replace(*edit, 1), encoding="utf-8")
    return folder


NORMAL = "vec3 outwards = vector_minus(ray_at(*r, t), obj->center);"


@pytest.mark.usefixtures("warmed")
@pytest.mark.parametrize("broken", [False, True])
def test_a_child_tells_what_changed_in_a_few_lines(
    broken: bool, tmp_path: Path, cache: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """The exercise, its first wrong check and a question; nothing is written.

    What does not compile is left to the whole report, which shows the compiler's line.
    """
    wrong = "vec3 outwards = ray_at(*r, t)" + ("" if broken else ";")
    folder, build = folder_of(tmp_path, (NORMAL, wrong)), tmp_path / "build"
    outputs(build, cache)
    words = [str(folder), "--build", str(build), "--lang", "fr", "--tp", "2", "-k", "TP2.4"]
    assert watch.in_child([*words, "--brief", "--sketch"], FRENCH) == ExitCode.DONE
    assert not (build / "grade").exists()
    said = capfd.readouterr().out.splitlines()
    if broken:
        assert said == []
        assert watch.in_child(words, FRENCH) == ExitCode.DONE
        assert "raytracer.c:" in capfd.readouterr().out
    else:
        title = FRENCH.say("exercise.TP2.4")
        assert said[:2] == [
            "Modifié : intersect_sphere",
            f"à revoir  TP2.4  {title}  intersect_sphere",
        ]
        assert (said[-2][-1], said[-1]) == ("?", "")


@pytest.mark.usefixtures("warmed")
def test_a_child_that_dies_is_one_line(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """The grade counts as one that the machine failed, and watching goes on."""
    monkeypatch.setattr(commands, "main", lambda _: os.kill(os.getpid(), signal.SIGKILL))
    assert watch.in_child([], FRENCH) == ExitCode.FAILED
    assert capfd.readouterr().err == FRENCH.say("watch.died", signal=9) + "\n"


@pytest.mark.usefixtures("warmed")
def test_an_interrupt_waits_for_the_child(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """The child is told, ends in order, and is gone; nothing is printed."""
    ended = tmp_path / "ended"

    def stay(_: Sequence[str]) -> int:
        parent = os.getppid()
        # A signal that comes just before a wait does not end it: not waitpid, nor pause().
        while Path(f"/proc/{parent}/stat").read_bytes().rpartition(b")")[2].split()[0] != b"S":
            time.sleep(0.01)
        try:
            os.kill(parent, signal.SIGINT)
            while True:
                time.sleep(0.01)
        except KeyboardInterrupt:
            ended.touch()
            return ExitCode.INTERRUPTED

    monkeypatch.setattr(commands, "main", stay)
    with pytest.raises(KeyboardInterrupt):
        watch.in_child([], FRENCH)
    assert ended.exists()
    assert capfd.readouterr() == ("", "")


class Terminal(io.StringIO):
    """A file that says it is a terminal."""

    def isatty(self) -> bool:
        """Say so."""
        return True

    @property
    def encoding(self) -> str:  # type: ignore[override]
        """Return that of most terminals."""
        return "utf-8"


@pytest.mark.parametrize(
    ("variables", "shown"),
    [
        ({"TERM": "xterm-256color"}, True),
        ({"TERM": "xterm", "COLORTERM": "truecolor"}, True),
        ({"TERM": "dumb", "COLORTERM": "truecolor"}, False),
        ({"TERM": "xterm-256color", "NO_COLOR": "1"}, False),
        ({"TERM": "xterm"}, False),
    ],
)
def test_a_picture_is_for_terminals_that_can_show_it(
    variables: dict[str, str], shown: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With the colours for it; a file or a pipe is none."""
    for name in ("TERM", "COLORTERM", "NO_COLOR", "FORCE_COLOR", "TTY_COMPATIBLE"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert sketch.can_show(Terminal()) == shown
    assert not sketch.can_show(io.StringIO())


def test_a_cell_holds_two_pixels() -> None:
    """The upper one is the letter's colour, the lower one that of its ground."""
    pixels = np.zeros((4, 8, 3), np.uint8)
    pixels[:2, :4] = (255, 0, 0)
    pixels[2:, :4] = (0, 0, 255)
    text = sketch.cells(pixels, 4)
    assert text.plain == sketch.HALF * 4
    styles = [str(each.style) for each in text.spans]
    assert styles[0] == "#ff0000 on #0000ff"
    assert styles[-1] == "#000000 on #000000"


@pytest.mark.parametrize("draws", [True, False])
def test_the_scene_is_drawn_by_the_submission(
    draws: bool, tmp_path: Path, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Lines of cells, of the reference's scene; nothing of code that draws nothing."""
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.delenv("NO_COLOR", raising=False)
    edit = ("", "") if draws else ("void raytrace(void) {", "void raytrace(void) {\n    return;")
    terminal = Terminal()
    with Libraries(read_submission(folder_of(tmp_path, edit)), (UNIT,), cache, lazy=True) as made:
        sketch.show(made, terminal)
    lines = terminal.getvalue().splitlines()
    assert [each.count(sketch.HALF) for each in lines] == ([64] * 21 if draws else [])
