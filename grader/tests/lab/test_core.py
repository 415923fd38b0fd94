"""Calling C from Python: values in and out, arrays of them, scenes and pictures."""

from __future__ import annotations

import numpy as np
import pytest

from grader.lab import Core, Picture, Stopped
from grader.lab.display.values import Hit, Miss, Ray
from grader.lab.display.vectors import Vec3

RED, YELLOW = (1, 0, 0), (1, 1, 0)


def test_a_picture_is_drawn_in_place(core: Core) -> None:
    """What C writes stands in the array that was passed, row 0 at the bottom."""
    img = core.image()
    assert core.fill_circle(img, 10, (48, 16), YELLOW) is None
    assert tuple(img[16, 48]) == YELLOW
    assert tuple(img[48, 48]) == (0, 0, 0)
    # Strictly nearer than 10: as many whole points as x*x + y*y < 100 has.
    assert int((img == YELLOW).all(axis=2).sum()) == 305


def test_a_picture_chooses_its_size(core: Core) -> None:
    """The build follows the picture: all of it is filled, whatever core.size."""
    img = core.image((32, 24))
    core.fill_red(img)
    assert img.shape == (24, 32, 3)
    assert (img == RED).all()


def test_a_hit_and_a_miss(core: Core) -> None:
    """A sphere of radius 1 seen from 3 is met at 2; a ray beside it gives a Miss, false."""
    ball = core.sphere((0, 0, 0), 1, kd=RED)
    hit = core.intersect_sphere(core.ray((0, 0, 3), (0, 0, -1)), ball)
    assert isinstance(hit, Hit)
    assert hit
    assert (hit.hit, hit.t) == (True, 2.0)
    assert tuple(hit.position) == tuple(hit.normal) == (0, 0, 1)
    assert tuple(hit.material.kd) == RED
    assert "scene units" in repr(hit)
    miss = core.intersect_sphere(core.ray((0, 0, 3), (0, 1, 0)), ball)
    assert isinstance(miss, Miss)
    assert not miss
    assert np.isnan(miss.t)


def test_three_rays_are_no_vector(core: Core) -> None:
    """Of three rays, as of any number, .hit and .t are plain arrays, one item for each ray."""
    rays = core.ray((0, 0, 3), [(0, 0, -1), (0, 1, 0), (0, 0, -1)])
    hits = core.intersect_sphere(rays, core.sphere((0, 0, 0), 1))
    assert hits.shape == (3,)
    assert type(hits.hit) is type(hits.t) is np.ndarray
    assert hits.hit.tolist() == [True, False, True]
    assert hits.position.shape == (3, 3)
    assert isinstance(hits[0].position, Vec3)


def test_a_hit_goes_back_into_c(core: Core) -> None:
    """What one function returns is what the next one takes."""
    ray = core.camera_ray(48.5, 32.5)
    hit = core.nearest_hit(ray)
    bounced = core.reflected_ray(ray, hit)
    assert isinstance(bounced, Ray)
    assert bounced.depth == 1
    seen = core.direct_light(hit, -ray.dir)
    assert tuple(core.trace_ray(ray)) >= tuple(seen)
    assert core.in_shadow(hit, core.scene().lights[0]) in (True, False)


def test_a_thousand_rays_in_one_call(core: Core) -> None:
    """Arrays give arrays: each is what the ray alone gives."""
    x = np.linspace(-2, 2, 1000)
    orig = np.stack([x, 0 * x, 0 * x + 3], axis=1)
    rays = core.ray(orig, (0, 0, -1))
    hits = core.intersect_sphere(rays, core.sphere((0, 0, 0), 1))
    assert hits.t.shape == (1000,)
    np.testing.assert_array_equal(hits.hit, np.abs(x) < 1)
    inside = np.abs(x) < 1
    np.testing.assert_allclose(hits.t[inside], 3 - np.sqrt(1 - x[inside] ** 2), rtol=1e-5)
    assert np.isnan(hits.normal[~inside]).all()
    alone = core.intersect_sphere(rays[500], core.sphere((0, 0, 0), 1))
    assert alone.t == hits[500].t
    with pytest.raises(TypeError):
        bool(hits)


def test_more_rays_than_one_message_holds(core: Core) -> None:
    """Many calls are sent in parts, in order."""
    n1 = np.linspace(1, 2, 50_001)
    got = core.reflectance(n1, 1.0)
    np.testing.assert_allclose(got, ((n1 - 1) / (n1 + 1)) ** 2, rtol=1e-4, atol=1e-7)


def test_one_ray_for_each_pixel(core: Core) -> None:
    """camera_rays has the picture's shape, and the rays of the pixels' middles."""
    rays = core.camera_rays((32, 24))
    assert rays.shape == (24, 32)
    middle = core.camera_ray(5.5, 7.5, size=(32, 24))
    np.testing.assert_array_equal(rays.dir[7, 5], middle.dir)


def test_pictures_follow_their_options(core: Core) -> None:
    """A render starts black, and its options are those of the call only."""
    flat = core.render(scene=0, shading=False)
    assert isinstance(flat, Picture)
    assert flat.pixels == (96, 64)
    assert tuple(flat[0, 0]) == pytest.approx((0.5, 0.9, 0.7))
    lit = core.render(scene=0, shadows=False)
    assert not np.array_equal(lit, core.render(scene=0))
    np.testing.assert_array_equal(flat, core.render(shading=False))
    core.options(shading=False)
    np.testing.assert_array_equal(flat, core.render())


@pytest.mark.long
def test_tests_are_counted_per_pixel(core: Core) -> None:
    """A flat picture of three spheres takes three tests a pixel in a list; the tree takes fewer."""
    balls = [core.sphere((x, 0.3, 0), 0.1) for x in (-0.5, 0, 0.5)]
    core.set_scene(objects=balls)
    flat = core.tests(size=(24, 16), shading=False, octree=False)
    assert flat.shape == (16, 24)
    assert (flat == 3).all()
    crowd = core.tests(3, size=(24, 16), shading=False, octree=False)
    tree = core.tests(3, size=(24, 16), shading=False, octree=True)
    assert tree.mean() < crowd.mean() / 5


def test_a_scene_of_ones_own(core: Core) -> None:
    """One red ball and nothing else: red or sky; the texture of scene 6 is there too."""
    core.set_scene(objects=[core.sphere((0, 0.3, 0), 0.5, kd=RED)])
    img = core.render(shading=False)
    colors = {tuple(np.round(each, 3)) for each in np.asarray(img).reshape(-1, 3).tolist()}
    assert colors == {(1.0, 0.0, 0.0), (0.2, 0.2, 0.6)}
    assert len(core.scene().objects) == 1
    assert len(core.scene(6).objects) > 1
    assert core.render(scene=6).max() > 0


def test_values_tell_what_they_are(core: Core) -> None:
    """Names, units and patches of colour; nothing of cffi."""
    scene = core.scene(0)
    assert repr(scene.objects[1]).startswith("Sphere\n  center  (1, -0.05, 0)  [scene units]")
    assert "Plane" in repr(scene)
    assert "rgb(229,0,0)" in scene._repr_html_()
    assert repr(core.vector_add((1, 2, 3), (4, 5, 6))) == "(5, 7, 9)"
    assert core.vector_dot((1, 2, 3), (1, 1, 1)) == 6.0
    assert core.constant("EPSILON") == 0.0001
    assert "Blinn-Phong" in str(core.shade.__doc__)


@pytest.mark.parametrize(
    ("act", "sentence"),
    [
        (lambda core: core.fill(core.image()), "fill(img, c)"),
        (lambda core: core.fill(core.image(), (1, 2)), "The argument c"),
        (lambda core: core.intersect_sphere(3, 4), "The argument r"),
        (lambda core: core.vector_add(np.zeros((2, 3)), np.zeros((3, 3))), "(2,), (3,)"),
        (lambda core: core.render(scene=99), "no scene 99"),
        (lambda core: core.render(scene=0, shadow=True), "no field shadow"),
        (lambda core: core.set_scene(lights=[core.light((0, 0, 0))] * 4), "4 items"),
        (lambda core: core.figure("figure_9"), "figure_9"),
    ],
)
def test_wrong_use_is_told_in_a_sentence(core: Core, act: object, sentence: str) -> None:
    """A mistake in the notebook is a card too, and the next call works."""
    with pytest.raises(Stopped) as caught:
        act(core)  # type: ignore[operator]
    assert sentence in str(caught.value)
    assert core.vector_norm((3, 4, 0)) == 5.0


def test_an_unknown_function_names_its_neighbours(core: Core) -> None:
    """A slip of the keyboard is an AttributeError, as Python wants it, with a way out."""
    with pytest.raises(AttributeError, match="fill_red"):
        _ = core.fil_red
    assert "shade" in dir(core)


def test_the_folder_is_found_from_a_notebook(
    core: Core, folder: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without MRT_CORE, the first core_c from here upwards is the one."""
    from pathlib import Path

    assert isinstance(folder, Path)
    notebooks = folder.parent / "notebooks" / "en"
    notebooks.mkdir(parents=True)
    monkeypatch.delenv("MRT_CORE")
    monkeypatch.chdir(notebooks)
    assert repr(Core()) == f"Core({str(folder)!r})"
