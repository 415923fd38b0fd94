"""What goes wrong in the student's code, and that the next call works."""

from __future__ import annotations

import signal
import threading
from pathlib import Path

import pytest

from grader.build.records import Target
from grader.lab import Core, Stopped, check
from grader.lab.bridge import engine
from grader.tests.lab.conftest import Edit

DOT = "float n_l = vector_dot(n, l);"


def shade(core: Core) -> object:
    """Call the function that the tests break."""
    return core.shade((0, 0, 1), (0, 0, 1), (0, 0, 1), (1, 1, 1), core.material())


def stopped(core: Core) -> str:
    """Return what is shown in the place of the result."""
    with pytest.raises(Stopped) as caught:
        shade(core)
    return str(caught.value)


def test_a_saved_file_is_built_again(core: Core, edit: Edit) -> None:
    """The next call runs the new code, and a return to the old one gives the old result."""
    before = repr(shade(core))
    edit("raytracer.c", DOT, "float n_l = 2.f * vector_dot(n, l);")
    assert repr(shade(core)) != before
    edit("raytracer.c", "float n_l = 2.f * vector_dot(n, l);", DOT)
    assert repr(shade(core)) == before


def test_the_compiler_is_heard_at_the_students_line(core: Core, edit: Edit, folder: Path) -> None:
    """Place, line and caret, what it means, and a link; mended, all goes on."""
    edit("raytracer.c", DOT, DOT.replace(";", ""))
    text = (folder / "raytracer.c").read_text(encoding="utf-8")
    line = text[: text.index(DOT.replace(";", ""))].count("\n") + 1
    with pytest.raises(Stopped) as caught:
        shade(core)
    assert "error: expected" in str(caught.value)
    assert "^" in str(caught.value)
    assert "semicolon" in str(caught.value)
    # gcc names the next word's line; JupyterLab counts from 0.
    assert any(f"raytracer.c#line={line + k}" in caught.value.shown.html for k in (-1, 0, 1))
    assert "Traceback" not in str(caught.value)
    edit("raytracer.c", DOT.replace(";", ""), DOT)
    shade(core)


def test_an_error_in_a_header_is_told_at_the_include(core: Core, edit: Edit) -> None:
    """What is open before an #include makes the compiler stop in a system header."""
    edit("raytracer.c", '#include "raytracer.h"', 'int oops =\n#include "raytracer.h"')
    with pytest.raises(Stopped) as caught:
        shade(core)
    lines = str(caught.value).splitlines()
    (marked,) = (line for line in lines if line.startswith(">"))
    assert marked.endswith('| #include "raytracer.h"')
    assert lines[lines.index(marked) - 1].endswith("| int oops =")
    assert "just before that line" in str(caught.value)
    assert "error: expected" in str(caught.value)
    assert "raytracer.c#line=" in caught.value.shown.html


def test_a_crash_names_function_and_line(core: Core, edit: Edit) -> None:
    """The card has the sentence and the lines around; the next call, and other functions, work."""
    edit("raytracer.c", DOT, f"{DOT} volatile int *p = 0; *p = 1;")
    for _ in range(2):
        message = stopped(core)
        assert "in shade (raytracer.c:" in message
        assert "*p = 1;" in message
    assert core.vector_norm((3, 4, 0)) == 5.0
    assert core.render(scene=0, shading=False).max() > 0


def test_an_endless_loop_ends(core: Core, edit: Edit) -> None:
    """The line is named after core.seconds; the next call gets less time, as a small picture."""
    core.seconds = 1
    edit("raytracer.c", DOT, f"{DOT} for (volatile int k = 0;; k++) {{}}")
    message = stopped(core)
    assert "after 1 s" in message
    assert "in shade (raytracer.c:" in message
    core.seconds, small = 20, Target(*core.size)
    assert core.engine.limit(small) < 20
    edit("raytracer.c", " for (volatile int k = 0;; k++) {}", "")
    shade(core)
    assert core.engine.limit(small) == 20
    core.seconds = None
    assert core.engine.limit(Target(8, 5)) == 5 < core.engine.limit(Target(640, 360))


DEEP = "static float deep(vec3 n) {\n    return 1.f + deep(vector_normalized(n));\n}\n"
HEAD = "color shade(vec3 n"


@pytest.mark.parametrize(
    ("before", "code", "name", "line"),
    [
        (DEEP, "n_l += deep(n);", "deep", "return 1.f + deep"),
        ("", "return shade(n, v, l, light_color, mat);", "shade", "return shade"),
    ],
    ids=["through the given functions", "that an optimiser may turn into a loop"],
)
def test_calls_without_end_are_told_in_one_way(
    before: str, code: str, name: str, line: str, core: Core, edit: Edit, folder: Path
) -> None:
    """In a cell and in check(): the function, and the line at which it calls itself."""
    edit("raytracer.c", DOT, f"{DOT}\n    {code}")
    edit("raytracer.c", HEAD, f"{before}{HEAD}")
    text = (folder / "raytracer.c").read_text(encoding="utf-8")
    at = text[: text.index(line)].count("\n") + 1
    told = f"{name} calls itself again and again, without end, in {name} (raytracer.c:{at})."
    cell = stopped(core)
    assert told in cell
    assert f"> {at:4d} |" in cell
    assert told in check("TP3.1").text


def test_the_stop_button(core: Core, edit: Edit) -> None:
    """An interrupt of the kernel ends the call and names the line; the cells behind wait."""
    edit("raytracer.c", DOT, f"{DOT} for (volatile int k = 0;; k++) {{}}")
    core.vector_norm((0, 0, 0))  # built and started
    main = threading.main_thread().ident
    assert main is not None
    # SIGALRM stands for it: a shell's background jobs have SIGINT ignored.
    old = signal.signal(signal.SIGALRM, signal.default_int_handler)
    timer = threading.Timer(2.0, signal.pthread_kill, (main, signal.SIGALRM))
    timer.start()
    try:
        with pytest.raises(Stopped) as caught:
            shade(core)
    finally:
        timer.join()
        signal.signal(signal.SIGALRM, old)
    assert caught.value.by_hand
    assert "Stopped as you asked: shade" in str(caught.value)
    assert "raytracer.c:" in str(caught.value)
    assert core.vector_norm((3, 4, 0)) == 5.0


@pytest.mark.parametrize(
    ("code", "sentence"),
    [
        ("exit(3);", "ended the program (code 3)"),
        ("abort();", "abort"),
        ("not_there();", "not_there"),
    ],
)
def test_other_ends(core: Core, edit: Edit, code: str, sentence: str) -> None:
    """Each way out of a function has its own sentence."""
    edit("raytracer.c", DOT, f"{DOT} {code}")
    edit("raytracer.c", '#include "raytracer.h"', '#include "raytracer.h"\n#include <stdlib.h>')
    if code.startswith("not_there"):
        edit("raytracer.c", "#include <stdlib.h>", "#include <stdlib.h>\nvoid not_there(void);")
    assert sentence in stopped(core)


def test_what_is_printed_shows_in_the_cell(
    core: Core, edit: Edit, capsys: pytest.CaptureFixture[str]
) -> None:
    """As plain text, each line once, without control characters, and not without end."""
    edit("raytracer.c", DOT, f'{DOT} printf("<b>n.l %g\\x1b[31m\\n", n_l);')
    edit("raytracer.c", '#include "raytracer.h"', '#include "raytracer.h"\n#include <stdio.h>')
    shade(core)
    assert capsys.readouterr().out == "<b>n.l 1�[31m\n"
    core.render(scene=0)
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 41
    assert lines[-1].startswith("... and ")


def test_a_changed_given_file_is_named_once(
    core: Core, edit: Edit, capsys: pytest.CaptureFixture[str]
) -> None:
    """It is not used, and one remark says so, not one a call."""
    edit("scene.c", "0.2f", "0.9f")
    shade(core)
    shade(core)
    core.render(scene=0, size=(32, 24))
    assert capsys.readouterr().out.count("scene.c") == 1


def test_a_folder_without_files(tmp_path: Path) -> None:
    """The sentence names the folder."""
    with pytest.raises(Stopped, match="vide"):
        Core(tmp_path / "vide").vector_norm((0, 0, 0))


def test_few_sessions_stay(core: Core, monkeypatch: pytest.MonkeyPatch) -> None:
    """Another picture size ends the oldest session, so that processes do not pile up."""
    monkeypatch.setattr(engine, "MOST_SESSIONS", 1)
    first = core.engine.stage(Target(96, 64))
    second = core.engine.stage(Target(32, 24))
    assert second.session.get("object_count") == 0
    with pytest.raises(ValueError, match="over"):
        first.session.get("object_count")
    assert core.engine.stage(Target(96, 64)) is not first
