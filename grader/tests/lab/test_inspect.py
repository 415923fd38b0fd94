"""The pixel inspector: the first wrong value, the table, and what stops on the way."""

from __future__ import annotations

import builtins
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from grader.lab import Stopped, check, inspect
from grader.lab.display.card import escape
from grader.lab.inspector import widget
from grader.lab.inspector.jump import jump
from grader.lab.inspector.looking import InspectedScene
from grader.tests.lab.conftest import Edit
from grader.tests.support.sampling import sampled

SIZE = (320, 180)
SEED = 2015
# Random pixels of each scene: a thousand in all, fewer where each has more rays.
PIXELS = dict.fromkeys((0, 1, 2, 5), 165) | {6: 120, 8: 100, 4: 50, 3: 20, 7: 20, 10: 20, 9: 10}


@pytest.fixture
def opened() -> Iterator[list[InspectedScene]]:
    """Return a list whose inspectors are closed at the end."""
    made: list[InspectedScene] = []
    yield made
    for each in made:
        each.close()


@pytest.mark.long
@pytest.mark.parametrize("scene", sampled(PIXELS, [0, 5]))
def test_nothing_is_wrong_with_the_reference(
    folder: Path, opened: list[InspectedScene], scene: int
) -> None:
    """No value of the reference is named, at random pixels of every scene."""
    inspected = InspectedScene(folder, scene, SIZE, {})
    opened.append(inspected)
    dice = np.random.default_rng(SEED + scene)
    pixels = zip(
        dice.integers(SIZE[0], size=PIXELS[scene]),
        dice.integers(SIZE[1], size=PIXELS[scene]),
        strict=True,
    )
    found = {(int(i), int(j)): inspected.look(int(i), int(j)) for i, j in pixels}
    assert {at: each.fault for at, each in found.items() if each.fault or each.stopped} == {}


def test_the_sum_is_compared_with_trace_ray(
    folder: Path, edit: Edit, opened: list[InspectedScene]
) -> None:
    """A trace_ray that adds something of its own is told, with both colours."""
    edit(
        "raytracer.c",
        "return hit_color(r, &it);",
        "color c = hit_color(r, &it); c.x += 1.f; return c;",
    )
    shown = inspect(0, (160, 60), shadows=False)
    opened.append(shown.inspected)
    assert "Your trace_ray does something else here" in repr(shown)
    assert shown.seen.fault is not None
    assert shown.seen.fault.exercise == "TP2.6"


def test_a_table_for_every_ray(folder: Path, opened: list[InspectedScene]) -> None:
    """Each ray has its row, in the table and in the view; the picture has its words."""
    found = inspect("scene4.smooth", (160, 90))
    opened.append(found.inspected)
    html = found.shown().html
    rows = re.findall(r'<tr data-row="([\d.]+)">', html)
    assert rows[:5] == ["0", "0.0", "0.1", "0.2", "1"]
    assert html.count('scope="row"') == len(rows)
    assert ">The rays of this pixel</caption>" in html
    assert re.search(r'<svg [^>]*aria-label="On the left, the picture and pixel \(160, 90\)', html)
    assert "Each value of this pixel is the one expected." in repr(found)
    made = widget.make(found.inspected, found.seen)
    assert [each[0] for each in made.seen["rays"]] == rows
    made.pixel = [10, 170]
    assert made.seen["pixel"] == [10, 170]
    assert "the sky" in made.seen["html"]


def test_the_expected_value_waits_until_it_is_asked(
    folder: Path, edit: Edit, opened: list[InspectedScene]
) -> None:
    """The text names the value and the function; the reference's number is folded away."""
    edit("raytracer.c", "vec3 h = vector_normalized(vector_add(l, v));", "vec3 h = l;")
    found = inspect("scene0.blinn_phong")
    opened.append(found.inspected)
    fault = found.seen.fault
    assert fault is not None
    assert (fault.exercise, fault.function) == ("TP3.1", "shade")
    assert "The first value that goes wrong is what the light adds" in repr(found)
    assert fault.wanted not in repr(found)
    before, _, after = found.shown().html.partition("<details>")
    assert fault.wanted not in before
    assert fault.wanted in after
    assert "n.l of each light" not in before
    assert "n.l of each light" in after


@pytest.mark.long
@pytest.mark.parametrize(
    ("code", "words"),
    [
        ("volatile int *p = 0; *p = 1;", "in shade (raytracer.c:"),
        ("for (volatile int k = 0; k == 0;) {}", "shade"),
    ],
    ids=["crash", "loop"],
)
def test_what_stops_is_told_with_its_line(
    folder: Path, edit: Edit, opened: list[InspectedScene], code: str, words: str
) -> None:
    """A crash or a loop at a pixel gives its sentence; a mended file works at once."""
    line = "float n_l = vector_dot(n, l);"
    edit("raytracer.c", line, f"{line} {code}")
    found = inspect(0, (160, 60))
    opened.append(found.inspected)
    text = repr(found)
    assert "your code stops on the way" in text
    assert words in text
    assert "raytracer.c:" in text
    edit("raytracer.c", f"{line} {code}", line)
    assert found.at(160, 60).seen.stopped is None
    assert found.inspected.ended is None


def test_without_widgets_the_page_is_whole(
    folder: Path, opened: list[InspectedScene], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where anywidget is missing the cell shows the table, the picture and the text."""
    found = inspect(0, (160, 60))
    opened.append(found.inspected)
    assert "application/vnd.jupyter.widget-view+json" in found._repr_mimebundle_()
    whole = builtins.__import__

    def missing(name: str, *args: Any, **named: Any) -> Any:
        if name == "anywidget":
            raise ImportError(name)
        return whole(name, *args, **named)

    widget._kind.cache_clear()
    monkeypatch.setattr(builtins, "__import__", missing)
    bundle = found._repr_mimebundle_()
    assert sorted(bundle) == ["text/html", "text/plain"]
    assert "<table" in bundle["text/html"]


@pytest.mark.parametrize(("scene", "pixel"), [(99, None), ("scene99.flat", None), (0, (1, 2, 3))])
def test_wrong_use_is_a_sentence(folder: Path, scene: Any, pixel: Any) -> None:
    """No such scene, no such picture, no pixel: a card each."""
    with pytest.raises(Stopped):
        inspect(scene, pixel)


@pytest.mark.long
def test_a_failed_picture_leads_to_its_pixel(folder: Path, edit: Edit) -> None:
    """check() tells the pixel; below stands the inspector: a widget, or a page to be unfolded."""
    line = "sum = vector_add(sum, shade(it->normal, v, l, lights[k].col, &it->mat));"
    edit("raytracer.c", line, line.replace("l, lights", "vector_float_mul(-1.f, l), lights"))
    said = check("TP3.2")
    (pixel,) = said.pixels
    assert pixel.told in said.text
    assert f"{escape(pixel.told)}</p>" in said.html
    assert f'inspect("{pixel.picture}", ({pixel.i}, {pixel.j}))' in said.text
    found = jump(pixel)
    assert found is not None
    assert found.inspection.seen.fault is not None
    assert found.inspection.seen.fault.exercise == "TP3.2"
    bundle = found._repr_mimebundle_()
    assert "application/vnd.jupyter.widget-view+json" in bundle
    assert bundle["text/html"].startswith(f"<details><summary>{escape(found.title)}</summary>")
    assert '<tr data-row="0"' in bundle["text/html"]


def test_the_texture_of_the_expected_picture_is_lent(
    folder: Path, edit: Edit, opened: list[InspectedScene]
) -> None:
    """By a picture's name the globe is the expected one; its texel is judged in either case."""
    by_name, by_number = inspect("scene6.blinn_phong"), inspect(6, (160, 90))
    opened += [by_name.inspected, by_number.inspected]
    assert by_name.seen.pixel == (160, 90)  # nothing is wrong, so the middle
    turned = "acosf(vector_clamp(d, -1.f, 1.f).y)"
    edit("raytracer.c", turned, "acosf(-vector_clamp(d, -1.f, 1.f).y)")
    objects = by_number.inspected.objects()
    assert objects is not None
    globe = int(np.argmax(objects[90] == 0)) + 10
    for each in (inspect("scene6.blinn_phong"), by_number.at(globe, 90)):
        opened.append(each.inspected)
        assert each.seen.fault is not None
        assert each.seen.fault.exercise == "TP3.B2"
