"""The pixel inspector: the first wrong value, the table, and what stops on the way."""

from __future__ import annotations

import builtins
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from grader import manifest
from grader.dev import mistakes
from grader.expected import FOLDER
from grader.lab import Stopped, comparing, inspect
from grader.lab.inspector import widget
from grader.lab.inspector.jump import jump, picture_of
from grader.lab.inspector.looking import Looking, Seen
from grader.lab.inspector.worst import worst_pixel
from grader.lab.place import core_folder
from grader.pictures.plan import JUDGED
from grader.tests.lab.conftest import Edit

SIZE = (320, 180)
SEED = 2015
# Random pixels of each scene: a thousand in all. Those of scene 3 take ten times as long.
PIXELS = dict.fromkeys(range(11), 97) | {3: 30}
# Known mistakes, and a picture in which they show.
WRONG = {
    "camera_axes_swapped": "scene0.flat",
    "camera_left_right": "scene0.flat",
    "camera_aspect_forgotten": "scene0.flat",
    "plane_distance_sign": "scene0.flat",
    "plane_behind": "scene0.flat",
    "plane_tmax_ignored": "scene0.flat",
    "sphere_far_root": "scene0.flat",
    "sphere_b_sign": "scene0.flat",
    "sphere_tmax_kept": "scene0.flat",
    "sphere_normal_inwards": "scene0.blinn_phong",
    "sphere_normal_not_unit": "scene0.blinn_phong",
    "cylinder_endless": "scene2.flat",
    "shade_pi_forgotten": "scene0.blinn_phong",
    "shade_h_not_unit": "scene0.blinn_phong",
    "shade_cosine_forgotten": "scene0.blinn_phong",
    "light_direction_reversed": "scene0.blinn_phong",
    "light_first_only": "scene4.blinn_phong",
    "shadow_acne": "scene0.shadows",
    "shadow_answer_inverted": "scene0.shadows",
    "shadow_reversed": "scene0.shadows",
    "reflection_range_kept": "scene0.mirror",
    "schlick_without_power": "scene0.fresnel",
    "fresnel_lobe_added": "scene0.fresnel",
    "fresnel_mirror_missing": "scene0.fresnel",
}


@pytest.fixture
def opened() -> Iterator[list[Looking]]:
    """Return a list whose inspectors are closed at the end."""
    made: list[Looking] = []
    yield made
    for each in made:
        each.probe.close()


def _look(opened: list[Looking], name: str) -> Seen:
    """Return what is seen at the pixel of a picture that is most wrong."""
    options = comparing.options(name)
    looking = Looking(core_folder(), int(options.pop("scene")), SIZE, options)
    opened.append(looking)
    pixel = worst_pixel(FOLDER, comparing.plan(name), looking.picture)
    assert pixel is not None, "the mistake does not show"
    return looking.look(*pixel)


@pytest.mark.parametrize("scene", PIXELS)
def test_nothing_is_wrong_with_the_reference(
    folder: Path, opened: list[Looking], scene: int
) -> None:
    """No value of the reference is named, at random pixels of every scene."""
    looking = Looking(folder, scene, SIZE, {})
    opened.append(looking)
    dice = np.random.default_rng(SEED + scene)
    pixels = zip(
        dice.integers(SIZE[0], size=PIXELS[scene]),
        dice.integers(SIZE[1], size=PIXELS[scene]),
        strict=True,
    )
    found = {(int(i), int(j)): looking.look(int(i), int(j)) for i, j in pixels}
    assert {at: each.fault for at, each in found.items() if each.fault or each.stopped} == {}


@pytest.mark.parametrize(("name", "picture"), WRONG.items())
def test_the_first_wrong_value_is_that_of_the_mistake(
    folder: Path, opened: list[Looking], name: str, picture: str
) -> None:
    """Where the picture is most wrong, the exercise named is the one the mistake was made in."""
    mistake = next(each for each in mistakes.load() if each.id == name)
    for file, text in mistake.files().items():
        (folder / file).write_text(text, encoding="utf-8")
    seen = _look(opened, picture)
    assert seen.fault is not None
    assert seen.fault.exercise == mistake.exercise


def test_the_sum_is_compared_with_trace_ray(
    folder: Path, edit: Edit, opened: list[Looking]
) -> None:
    """A trace_ray that adds something of its own is told, with both colours."""
    edit(
        "raytracer.c",
        "return hit_color(r, &it);",
        "color c = hit_color(r, &it); c.x += 1.f; return c;",
    )
    shown = inspect(0, (160, 60), shadows=False)
    opened.append(shown.looking)
    assert "Your trace_ray does something else here" in repr(shown)
    assert shown.seen.fault is not None
    assert shown.seen.fault.exercise == "TP2.6"


def test_a_table_for_every_ray(folder: Path, opened: list[Looking]) -> None:
    """Each ray has its row, in the table and in the view; the picture has its words."""
    found = inspect("scene4.smooth", (160, 90))
    opened.append(found.looking)
    html = found.shown().html
    rows = re.findall(r'<tr data-row="([\d.]+)">', html)
    assert rows[:5] == ["0", "0.0", "0.1", "0.2", "1"]
    assert html.count('scope="row"') == len(rows)
    assert ">The rays of this pixel</caption>" in html
    assert re.search(r'<img [^>]*alt="On the left, the picture and pixel \(160, 90\)', html)
    assert "Each value of this pixel is the one expected." in repr(found)
    made = widget.make(found.looking, found.seen)
    assert [each[0] for each in made.seen["rays"]] == rows
    made.pixel = [10, 170]
    assert made.seen["pixel"] == [10, 170]
    assert "the sky" in made.seen["html"]


def test_the_expected_value_waits_until_it_is_asked(
    folder: Path, edit: Edit, opened: list[Looking]
) -> None:
    """The text names the value and the function; the reference's number is folded away."""
    edit("raytracer.c", "vec3 h = vector_normalized(vector_add(l, v));", "vec3 h = l;")
    found = inspect("scene0.blinn_phong")
    opened.append(found.looking)
    fault = found.seen.fault
    assert fault is not None
    assert (fault.exercise, fault.function) == ("TP3.1", "shade")
    assert "The first value that goes wrong is what the light adds" in repr(found)
    assert fault.wanted not in repr(found)
    before, _, after = found.shown().html.partition("<details>")
    assert fault.wanted not in before
    assert fault.wanted in after


@pytest.mark.parametrize(
    ("code", "words"),
    [
        ("volatile int *p = 0; *p = 1;", "in shade (raytracer.c:"),
        ("for (volatile int k = 0; k == 0;) {}", "shade"),
    ],
    ids=["crash", "loop"],
)
def test_what_stops_is_told_with_its_line(
    folder: Path, edit: Edit, opened: list[Looking], code: str, words: str
) -> None:
    """A crash or a loop at a pixel gives its sentence; a mended file works at once."""
    line = "float n_l = vector_dot(n, l);"
    edit("raytracer.c", line, f"{line} {code}")
    found = inspect(0, (160, 60))
    opened.append(found.looking)
    text = repr(found)
    assert "your code stops on the way" in text
    assert words in text
    assert "raytracer.c:" in text
    edit("raytracer.c", f"{line} {code}", line)
    assert found.at(160, 60).seen.stopped is None
    assert found.looking.ended is None


def test_without_widgets_the_page_is_whole(
    folder: Path, opened: list[Looking], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where anywidget is missing the cell shows the table, the picture and the text."""
    found = inspect(0, (160, 60))
    opened.append(found.looking)
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


def test_every_check_of_a_picture_leads_to_it() -> None:
    """The inspector knows which picture a check judges, and opens on it by name."""
    checks = [each.id for row in manifest.load().exercises for each in row.checks]
    found = [picture_of(each) for each in checks if ".scene." in each]
    assert {each for each in found if each is not None} == set(JUDGED)
    assert None not in found
    assert picture_of("tp2.intersect_sphere.meets") is None


def test_a_failed_picture_names_its_pixel(folder: Path, edit: Edit) -> None:
    """Tell the worst pixel and its first wrong value, with the inspector folded below."""
    edit("raytracer.c", "float n_l = vector_dot(n, l);", "float n_l = -vector_dot(n, l);")
    shown = jump("tp3.scene.blinn_phong_0")
    assert shown is not None
    assert "The first value that goes wrong is what the light adds" in shown.text
    assert re.search(r'inspect\("scene0.blinn_phong", \(\d+, \d+\)\)', shown.text)
    assert '<tr data-row="0"' in shown.html.partition("<details>")[2]
