"""live(): what is seen after each save, without a browser; and who follows."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from grader.lab import Stopped, live
from grader.lab.bridge.engine import last_engine
from grader.lab.live.follower import STEP, Follower, View
from grader.tests.lab.conftest import Edit

SIZE = (96, 64)
DOT = "float n_l = vector_dot(n, l);"


@pytest.fixture
def follower(folder: Path) -> Iterator[Follower]:
    """Return a follower of the folder, on scene 0 without shadows, which has drawn it once."""
    made = Follower(folder, 0, SIZE, {"shadows": False})
    seen = after(made)
    assert [each.coarse for each in seen] == [False, True, False]
    yield made
    made.close()


def after(follower: Follower) -> list[View]:
    """Return what is shown at the next look; nothing when no file was saved."""
    seen: list[View] = []
    assert follower.look(seen.append) == bool(seen)
    return seen


def picture(view: View) -> np.ndarray[tuple[int, ...], np.dtype[np.float32]]:
    """Return the picture of a view, which has one."""
    assert view.picture is not None
    return np.asarray(view.picture)


def test_the_coarse_picture_is_part_of_the_whole(follower: Follower, edit: Edit) -> None:
    """It holds the pixels in the middle of the blocks; nothing is drawn while nothing is saved."""
    assert after(follower) == []
    edit("raytracer.c", DOT, "float n_l = 1.f * vector_dot(n, l);")
    _, coarse, *_, last = after(follower)
    assert picture(coarse).shape == (SIZE[1] // STEP, SIZE[0] // STEP, 3)
    middle = slice(STEP // 2, None, STEP)
    assert np.allclose(picture(coarse), picture(last)[middle, middle])
    assert "TP3.1 shade: right" in last.verdicts.text


@pytest.mark.long
def test_what_changed_is_judged(follower: Follower, edit: Edit) -> None:
    """The exercises of the function, no others; and again when it is mended."""
    edit("raytracer.c", DOT, "float n_l = -vector_dot(n, l);")
    wrong = after(follower)[-1]
    told = wrong.verdicts.text
    assert told.count("shade: ") == 2  # TP3.1 and TP5.2 are written in it
    assert "TP3.1 shade: to review, 0 / 12" in told
    assert "is expected" in told
    edit("raytracer.c", "float n_l = -vector_dot(n, l);", DOT)
    right = after(follower)[-1]
    assert "TP3.1 shade: right, 12 / 12" in right.verdicts.text
    assert not np.allclose(picture(wrong), picture(right))


@pytest.mark.long
def test_what_does_not_compile_keeps_the_picture(follower: Follower, edit: Edit) -> None:
    """The compiler's line stands beside the last picture; what was changed is judged later."""
    edit("raytracer.c", DOT, "float n_l = -vector_dot(n, l)")
    broken = after(follower)[-1]
    assert "does not compile yet. Mend it and save" in broken.told.text
    assert "raytracer.c:" in broken.told.text
    assert picture(broken).shape == (SIZE[1], SIZE[0], 3)
    assert broken.verdicts.text == ""
    edit("raytracer.c", "vector_dot(n, l)", "vector_dot(n, l);")
    mended = after(follower)[-1]
    assert mended.told.text == ""
    assert "TP3.1 shade: to review" in mended.verdicts.text


@pytest.mark.long
@pytest.mark.parametrize(
    ("act", "words"),
    [
        ("volatile int *p = 0; *p = 1;", "raytrace()"),
        ("for (volatile int k = 1; k;) { }", "trace_ray() does not end: stopped after 2 s"),
    ],
)
def test_a_crash_and_a_loop_are_sentences(
    follower: Follower, edit: Edit, act: str, words: str
) -> None:
    """They name the line; a loop is met once, in the coarse picture, and not waited for again.

    Not by the checks either: they look once it is gone.
    """
    edit("raytracer.c", DOT, f"{DOT} {act}")
    ended = after(follower)[-1]
    assert bool(ended.verdicts.text) == ("does not end" not in words)
    assert words in ended.told.text
    assert "(raytracer.c:" in ended.told.text
    assert "no new picture" in ended.state


def test_what_is_printed_stands_beside_the_picture(
    follower: Follower, edit: Edit, capsys: pytest.CaptureFixture[str]
) -> None:
    """It is not written into the cell that happens to run."""
    edit("raytracer.c", "void raytrace(void) {", 'void raytrace(void) { printf("here\\n");')
    edit("raytracer.c", '#include "raytracer.h"', '#include "raytracer.h"\n#include <stdio.h>')
    assert after(follower)[-1].told.text == "here"
    assert capsys.readouterr().out == ""


@pytest.mark.long
def test_a_stub_is_drawn_as_it_is(follower: Follower, edit: Edit) -> None:
    """What is still to write is no error: the picture is what there is, the verdict "to do"."""
    edit("raytracer.c", DOT, 'MRT_TODO("TP3.1"); return vector_init(0.f, 0.f, 0.f); ' + DOT)
    last = after(follower)[-1]
    assert last.told.text == ""
    assert "TP3.1 shade: to do" in last.verdicts.text


def test_one_follows_at_a_time(folder: Path) -> None:
    """The one before stays as it is; neither takes the place of the notebook's own tool."""
    first = live(0, size=SIZE)
    assert "Drawn at" in repr(first)
    second = live("scene4.shadows", size=SIZE)
    assert (second.follower.scene, second.follower.chosen["shadows"]) == (4, True)
    assert "follows your files no more" in repr(first)
    assert "Drawn at" in repr(second)
    assert last_engine() is None
    static = second._repr_mimebundle_()
    assert static["text/html"].startswith('<img src="data:image/png;base64,')
    second.stop()
    with pytest.raises(Stopped, match="figure_99"):
        live("figure_99")
