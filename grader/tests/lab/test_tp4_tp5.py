"""The drawings of TP4 and TP5: what they count and read in the student's process, and say."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
import pytest

from grader.lab import Core, Stopped
from grader.lab.bridge.counting import counter
from grader.lab.drawings import tp4, tp4_octree, tp5, tp5_samples

Edit = Callable[[str, str, str], None]

WALK = "w.inverse = vector_init("  # in the reference's octree_intersect
PLANTED = "if (t->out_of_memory) {\n        octree_free"  # and in its octree_build


def test_the_list_is_tested_whole_and_the_tree_is_not(core: Core) -> None:
    """Each ray through the plain list tests every object; the octree spares most of them."""
    objects = core.scene(3).objects.data
    rays = core.camera_ray(np.array([10.5, 48.5, 70.5]), np.array([5.5, 32.5, 40.5])).data
    with counter(core) as counting:
        counting.place(objects, octree=False)
        assert counting.each(rays).tolist() == [len(objects)] * 3
        counting.place(objects, octree=True)
        counts = counting.each(rays)
        assert counting.total(rays) == counts.sum()
    assert 0 < counts.max() < len(objects) / 4


def test_a_crash_while_counting_is_told(core: Core, edit: Edit) -> None:
    """The cell is stopped with the function and its line, as for any other call."""
    edit("octree.c", WALK, f"*(volatile int *)0 = 1;\n    {WALK}")
    with pytest.raises(Stopped, match=r"octree_intersect \(octree\.c:"):
        tp4_octree.tests_curve(core)


def test_what_does_not_compile_cannot_be_counted(core: Core, edit: Edit) -> None:
    """The compiler's line is shown."""
    edit("octree.c", WALK, f"int x = ;\n    {WALK}")
    with pytest.raises(Stopped, match=r"int x = ;"), counter(core):
        pass


def test_a_tree_that_holds_itself_is_read_to_an_end(core: Core, edit: Edit) -> None:
    """A student's tree may have a loop: as much of it is shown as can be read."""
    loop = "for (int k = 0; k < 8; k++) t->root.child[k] = k ? NULL : &t->root;"
    edit("octree.c", PLANTED, f"{loop}\n    {PLANTED}")
    assert f"depth {tp4_octree.DEEPEST}" in tp4_octree.boxes(core, 1).text


def test_the_boxes_are_those_of_the_tree(core: Core) -> None:
    """The root at depth 0, its eight parts at depth 1; without a tree, a sentence."""
    assert "boxes drawn: 1;" in tp4_octree.boxes(core, 0).text
    assert "boxes drawn: 8;" in tp4_octree.boxes(core, 1).text
    core.options(octree=False)
    assert "no tree yet" in tp4_octree.boxes(core, 1).text


def test_a_quadtree_lists_every_disc(monkeypatch: pytest.MonkeyPatch) -> None:
    """Uncut, one box lists each disc once; cut, some stand in several boxes."""
    monkeypatch.setenv("MRT_LANG", "en")
    assert "Boxes: 1; discs: 14, listed 14 times, 14 at most" in tp4_octree.quadtree(cuts=0).text
    found = re.search(r"listed (\d+) times", tp4_octree.quadtree(cuts=3).text)
    assert found
    assert int(found[1]) > 14


@pytest.mark.parametrize(
    ("angle", "height", "words"),
    [
        (0, 0.0, "within both slabs from t = 1.4 to t = 3.4"),
        (0, 1.5, "the box is missed"),
        (45, 0.0, "the box is missed"),
        (45, -1.0, "within both slabs from t = 1.98 to t = 2.83"),
    ],
)
def test_a_box_is_two_slabs(
    monkeypatch: pytest.MonkeyPatch, angle: int, height: float, words: str
) -> None:
    """A ray crosses it where it is between the lines both ways; along an axis too."""
    monkeypatch.setenv("MRT_LANG", "en")
    assert words in tp4_octree.slabs(angle, height).text


@pytest.mark.parametrize(("x", "barred"), [(-0.4, True), (-1.7, False), (2.0, False)])
def test_only_what_stands_before_the_light_bars_it(core: Core, x: float, barred: bool) -> None:
    """At -0.4 a ball stands in the way; at -1.7 one stands beyond the light, in line."""
    assert ("true" if barred else "false") in tp4.shadow_ray(core, x).text


def test_rays_bounce_no_deeper_than_asked(core: Core) -> None:
    """One bar more than max_depth: the rays of the eye have depth 0."""
    core.options(max_depth=2)
    assert tp4.rays_per_depth(core, 4).text.count(";") == 2


@pytest.mark.parametrize(
    ("angle", "inside", "words"),
    [(50, False, "leaves at 30.7"), (30, True, "leaves at 48.6"), (50, True, "returns false")],
)
def test_snell(core: Core, angle: int, inside: bool, words: str) -> None:
    """Into glass a ray nears the normal, out of it it leaves it, and may be held back."""
    assert words in tp5.snell(core, angle, 1.5, inside).text


@pytest.mark.long
def test_noise_falls_more_slowly_than_stair_steps(core: Core) -> None:
    """Random choices have slope -1/2; a regular grid along an edge is steeper."""
    slopes = []
    for scene in (0, 7):
        found = re.search(r"slope: (-\d\.\d+)", tp5_samples.error_curve(core, scene).text)
        assert found
        slopes.append(float(found[1]))
    assert slopes[0] < -0.65
    assert -0.65 < slopes[1] < -0.4


def test_a_fractal_is_counted(core: Core) -> None:
    """1 + 3 + 9 spheres at depth 2."""
    assert tp5.fractal(core, 2).text == "depth = 2; spheres: 13"
