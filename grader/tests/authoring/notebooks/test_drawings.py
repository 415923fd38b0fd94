"""The notebooks' drawings: what they tell is true, and they tell it in words too."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from grader.course.exercises import CORE, ROOT
from grader.lab import Core, show
from grader.lab.display import plots
from grader.lab.display.card import Shown
from grader.lab.drawings import tp1, tp2, tp3, vectors


@pytest.fixture(scope="module")
def core(cache: Path) -> Iterator[Core]:
    """Return the finished program, as a notebook uses it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("BUILD", str(cache))
        patch.setenv("MRT_LANG", "en")
        made = Core(ROOT / "reference")
        made.options(shadows=False, reflections=False, fresnel=False)
        yield made
        made.close()


@pytest.fixture(autouse=True)
def english(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the words be English."""
    monkeypatch.setenv("MRT_LANG", "en")


GROUNDS = ("#ffffff", "#111111")  # of JupyterLab's themes

PLAIN: list[Callable[[], Shown]] = [
    tp1.memory_strip,
    tp1.interpolation,
    lambda: tp1.column_profile(np.ones((9, 16, 3))),
    lambda: tp1.rectangle_grid((2, 1), (5, 3)),
    tp1.distance_map,
    tp1.circle_tests,
    tp2.ray_points,
    tp2.plane_meeting,
    tp2.sphere_curve,
    tp2.cylinder_section,
    tp3.patch,
    tp3.n_dot_l,
    tp3.half_vector,
    tp3.lobe,
    tp3.normalisation,
    tp3.floor_and_int,
    vectors.products,
]


@pytest.mark.parametrize("language", ["fr", "en"])
@pytest.mark.parametrize("number", range(len(PLAIN)))
def test_a_drawing_has_words(number: int, language: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each drawing is one image whose description is a sentence, in both languages."""
    monkeypatch.setenv("MRT_LANG", language)
    shown = PLAIN[number]()
    (words,) = re.findall(r'<svg\b[^>]*\baria-label="([^"]*)"', shown.html)
    assert len(words) > 40
    assert words.endswith(".")
    assert "{" not in words


def contrast(one: str, other: str) -> float:
    """Return the contrast of two colours such as "#0072b2", as WCAG 2.1 has it."""
    low, high = sorted(map(luminance, (one, other)))
    return (high + 0.05) / (low + 0.05)


def luminance(color: str) -> float:
    """Return the relative luminance of a colour."""
    levels = np.array([int(color[k : k + 2], 16) / 255 for k in (1, 3, 5)])
    linear = np.where(levels <= 0.04045, levels / 12.92, ((levels + 0.055) / 1.055) ** 2.4)
    return float(linear @ (0.2126, 0.7152, 0.0722))


@pytest.mark.parametrize("number", range(len(PLAIN)))
def test_a_drawing_is_seen_on_light_ground_and_on_dark(number: int) -> None:
    """No sheet behind it, the page's ink for words, and lines that stand out from both grounds."""
    html = PLAIN[number]().html
    figure = html.partition('<g class="mrt-axes"')[0]
    assert "fill:" not in figure
    words = "".join(re.findall(r'<g class="mrt-text">.*?</g>', html, re.S))
    assert set(re.findall(r"fill: (#\w{6})", words)) <= {plots.ON_DARK, plots.ON_BRIGHT}
    colors = set(re.findall(r"stroke: (#\w{6})", html)) - {plots.ON_DARK, plots.ON_BRIGHT}
    assert [each for each in colors if min(contrast(each, ground) for ground in GROUNDS) < 3] == []


def test_many_pixels_are_scaled_and_few_stay_sharp() -> None:
    """No column of a large picture is dropped; the pixels of a small one have edges."""
    large, small = (show(np.zeros((9, width, 3))).html for width in (1280, 8))
    assert "<image" in large
    assert "pixelated" not in large
    assert "pixelated" in small


def test_numbers_follow_the_language(monkeypatch: pytest.MonkeyPatch) -> None:
    """A comma and a thin space in French; no zeros that say nothing."""
    assert [plots.number(921600, 0), plots.number(0.50, 2)] == ["921,600", "0.5"]
    assert plots.triple((1, -0.0, 0.25)) == "(1, 0, 0.25)"
    monkeypatch.setenv("MRT_LANG", "fr")
    thin = "\N{NARROW NO-BREAK SPACE}"
    assert [plots.number(921600, 0), plots.number(0.50, 2)] == [f"921{thin}600", "0,5"]
    assert plots.triple((1, -0.0, 0.25)) == "(1 ; 0 ; 0,25)"
    assert [plots.digits(0.0139, 2), plots.digits(81.06, 3)] == ["0,014", "81,1"]


def test_tp1_counts() -> None:
    """The numbers that TP1 announces."""
    assert "k is 12: the box of column 0 and row 2" in tp1.memory_strip(6, 1).text
    assert "921,600 pixels in the image, 16,641 in the bounding box" in tp1.circle_tests(64).text
    assert "12 pixels" in tp1.rectangle_grid((2, 1), (5, 3)).text
    assert [row.split()[1:] for row in tp1.division_table(360).text.splitlines()[2:4]] == [
        ["0", "0.25"],
        ["0", "0.5"],
    ]
    assert "11,059,200" in tp1.memory_sizes().text


@pytest.mark.parametrize(
    ("height", "start", "count", "found"),
    [(0.5, -3.0, 2, "2.13"), (0.5, 0.0, 2, "0.87"), (0.5, 2.0, 2, "none"), (1.5, -3.0, 0, "none")],
)
def test_roots_of_the_sphere(height: float, start: float, count: int, found: str) -> None:
    """The root that is told is the first in front: both, one, or none of them are."""
    assert f"roots: {count}, t we look for: {found}." in tp2.sphere_curve(height, start).text


def test_where_a_ray_meets_a_plane() -> None:
    """In front, behind, and parallel."""
    assert "t = 2.92: in front" in tp2.plane_meeting(-20).text
    assert "behind, no intersection" in tp2.plane_meeting(20).text
    assert "parallel" in tp2.plane_meeting(0).text


@pytest.mark.parametrize(
    ("tilt", "entry", "leave"),
    [(0, "upper disc", "lower disc"), (45, "upper disc", "side"), (90, "side", "side")],
)
def test_where_a_ray_meets_a_cylinder(tilt: int, entry: str, leave: str) -> None:
    """TP2's prediction, at 45 degrees, and the two ends of the slider."""
    assert f"It enters by the {entry} and leaves by the {leave}." in tp2.cylinder_section(tilt).text


def test_products_of_two_vectors() -> None:
    """At 60 degrees and at a right angle."""
    assert "Dot product: 1; length of the cross product: 1.73." in vectors.products(60, 2).text
    assert "Dot product: 0; length of the cross product: 0.5." in vectors.products(90, 0.5).text


def test_camera(core: Core) -> None:
    """Figure 3 is black at the bottom left; the dot product in a corner is that of TP2's answer."""
    assert "Darkest corner: at the bottom left." in tp2.directions(core).text
    assert "1 in the middle, 0.83 in a corner" in tp2.dot_product(core).text
    assert "pixel (3, 2)" in tp2.pyramid(core, 3, 2).text


def test_what_a_ray_meets(core: Core) -> None:
    """The pixel of the grey sphere, and one of the sky; 81 % of scene 0 is no sky."""
    assert "the 2 objects" in tp2.probe(core, 320, 160).text
    assert "no object: the sky" in tp2.probe(core, 0, 359).text
    assert "An object is hit in 81 %" in tp2.depth_and_normals(core).text
    assert "scene 0 if no object lowered tmax" in tp2.last_object_wins(core).text.lower()


def test_lighting(core: Core) -> None:
    """TP3's numbers: cosines, the mirror's law, and where the lobe points."""
    assert "0.5 times the light" in tp3.patch(60).text
    assert "h.n = 1." in tp3.half_vector(-40, 40).text
    assert "maximum is at 40 degrees" in tp3.lobe(-40, 200).text
    assert "81 % of the ball is lit" in tp3.shaded_ball(core).text
    assert tp3.checkered_ball(core, 0.4).shape == (363, 363, 3)


def test_the_clamp_shows_in_scene_4_only(core: Core) -> None:
    """TP3's surprise: scene 0 is the same to the last bit without the clamp on n.l."""
    told = re.search(
        r"changed: (\S+) % in scene 0, (\S+) % in scene 4", tp3.without_clamp(core).text
    )
    assert told
    assert float(told[1]) == 0
    assert float(told[2]) > 1


def test_lights_add_up(core: Core) -> None:
    """The mean of the whole is nearly the sum of the means, but for the sky in each picture."""
    text = tp3.one_light_at_a_time(core).text
    *parts, whole = map(float, re.findall(r"\d+\.\d+", text))
    assert len(parts) == 3
    assert sum(parts) == pytest.approx(whole, abs=0.02)


def test_drawings_of_a_program_not_begun(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """On the skeleton everything is drawn all the same: sky, black, one colour."""
    monkeypatch.setenv("BUILD", str(cache))
    core = Core(CORE)
    try:
        assert "none, the picture has one colour" in tp2.directions(core).text
        assert "An object is hit in 0 %" in tp2.depth_and_normals(core).text
        assert "no object: the sky" in tp2.probe(core).text
        assert "0 % of the ball is lit" in tp3.shaded_ball(core).text
        assert "0 % in scene 0, 0 % in scene 4" in tp3.without_clamp(core).text
    finally:
        core.close()
