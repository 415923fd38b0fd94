"""Whole pictures of the scenes at 160x90: octree or list, finite, the stages of the handout."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from grader.execution.session import Library, Limits, Session
from grader.tests.core.oracles import Array
from grader.tests.core.worlds import set_options, set_texture
from grader.tests.support import sources

WIDTH, HEIGHT = 160, 90
SKY = np.array([0.2, 0.2, 0.6], np.float32)
# Objects times pixels that the plain list may cost; a larger scene is compared on fewer pixels.
PLAIN_LIST_TESTS = 10_000_000


def picture(s: Session, scene: int, **options: float) -> Array:
    """Return the picture of a scene; options are set after the scene and stay."""
    assert s.call("setup_scene", scene).result
    set_options(s, **options)
    s.call("raytrace")
    return s.get("output_image")


def prepare(s: Session, core: Library, rng: np.random.Generator, scene: int) -> None:
    """Set a scene up with a texture, which only the program reads from its file."""
    set_texture(s, core, rng.random((8, 16, 3)))
    assert s.call("setup_scene", scene).result


@pytest.mark.parametrize("scene", sources.scenes())
def test_octree_and_list_draw_the_same(
    scenes: Library, rng: np.random.Generator, scene: int
) -> None:
    """Every pixel to the last bit, finite; of the largest scenes, pixels drawn by lot."""
    with scenes.session(Limits(cpu=60)) as s:
        prepare(s, scenes, rng, scene)
        s.call("raytrace")
        tree = s.get("output_image")
        count = min(WIDTH * HEIGHT, PLAIN_LIST_TESTS // int(s.get("object_count")))
        chosen = rng.permutation(WIDTH * HEIGHT)[:count]
        j, i = np.divmod(chosen, WIDTH)
        set_options(s, octree=False)
        r = s.call_many("camera_ray", count, scenes.zeros("ray"), i + 0.5, j + 0.5).args["r"]
        r["seed"] = s.call_many("pixel_seed", count, i, j, 0).result
        plain = s.call_many("trace_ray", count, r).result
    assert count >= 150
    assert np.isfinite(tree).all()
    assert tree.min() >= 0
    assert tree.std() > 0.05
    np.testing.assert_array_equal(tree[chosen], plain)


def test_raytrace_is_trace_ray_of_every_pixels_centre(scenes: Library) -> None:
    """Pixel (i, j) is output_image[j * WIDTH + i], row 0 at the bottom; two runs are the same."""
    with scenes.session() as s:
        got = picture(s, 4)
        np.testing.assert_array_equal(picture(s, 4), got)
        j, i = np.divmod(np.arange(WIDTH * HEIGHT), WIDTH)
        r = s.call_many("camera_ray", i.size, scenes.zeros("ray"), i + 0.5, j + 0.5).args["r"]
        np.testing.assert_array_equal(s.call_many("trace_ray", i.size, r).result, got)


def test_red_sphere_on_the_left_floor_at_the_bottom(scenes: Library) -> None:
    """Scene 0 lies as in the printed figures: the red sphere at x = 1 left, green on top."""
    with scenes.session() as s:
        flat = picture(s, 0, shading=False).reshape(HEIGHT, WIDTH, 3)
    rows, columns = np.nonzero((flat == np.array((0.9, 0, 0), np.float32)).all(axis=2))
    assert columns.mean() < WIDTH / 2
    greens, _ = np.nonzero((flat == np.array((0, 1, 0), np.float32)).all(axis=2))
    assert greens.mean() > rows.mean()
    floor = np.array((0.5, 0.9, 0.7), np.float32)
    np.testing.assert_array_equal(flat[0], np.broadcast_to(floor, (WIDTH, 3)))
    np.testing.assert_array_equal(flat[-1, 0], SKY)


@pytest.mark.parametrize("scene", range(5))
def test_without_shading_there_is_kd_or_sky(scenes: Library, scene: int) -> None:
    """Figure 4: the only colours are those of the materials and the sky."""
    with scenes.session() as s:
        colors = np.unique(picture(s, scene, shading=False), axis=0)
        world = s.get("scene", int(s.get("object_count")))
    allowed = {tuple(SKY), *map(tuple, world["mat"]["kd"])}
    assert set(map(tuple, colors)) <= allowed
    assert len(colors) > 4


def test_each_switch_changes_its_own_light(scenes: Library) -> None:
    """Shadows only darken; mirrors only add; each option changes the picture of scene 1."""
    with scenes.session() as s:
        bare = picture(s, 1, shadows=False, reflections=False, fresnel=False)
        shadows = picture(s, 1, shadows=True)
        mirrors = picture(s, 1, reflections=True)
        fresnel = picture(s, 1, fresnel=True)
    assert (shadows <= bare).all()
    assert (shadows < bare).any(axis=1).mean() > 0.02
    assert (mirrors >= shadows).all()
    assert (mirrors > shadows).any(axis=1).mean() > 0.3
    assert (fresnel != mirrors).any(axis=1).mean() > 0.3


def test_depth_limit(scenes: Library) -> None:
    """Depth 0 keeps the direct light only; each bounce allowed adds, and ten are nearly all."""
    with scenes.session() as s:
        direct = picture(s, 2, reflections=False)
        drawn = [picture(s, 2, reflections=True, max_depth=n) for n in (0, 1, 2, 10, 20)]
    np.testing.assert_array_equal(drawn[0], direct)
    for fewer, more in itertools.pairwise(drawn):
        assert (more >= fewer).all()
    assert (drawn[1] > drawn[0]).any(axis=1).mean() > 0.3
    assert np.abs(drawn[4] - drawn[3]).max() < 0.05


def test_samples_are_averaged(scenes: Library) -> None:
    """samples=3 is the picture of pixel_color, in [0, 1]; samples=1 the plain one."""
    with scenes.session() as s:
        plain = picture(s, 0, samples=1)
        smooth = picture(s, 0, samples=3)
        j, i = np.divmod(np.arange(WIDTH * HEIGHT), WIDTH)
        np.testing.assert_array_equal(s.call_many("pixel_color", i.size, i, j).result, smooth)
    assert smooth.min() >= 0
    assert smooth.max() <= 1
    inside = np.abs(smooth - np.clip(plain, 0, 1)).max(axis=1)
    assert (inside < 0.02).mean() > 0.7
    assert inside.max() > 0.1


def test_refraction_off_draws_opaque(scenes: Library) -> None:
    """Scene 7 without refraction has mirrors in the place of glass; nothing else changes."""
    with scenes.session() as s:
        glass = picture(s, 7)
        opaque = picture(s, 7, refraction=False)
    changed = (glass != opaque).any(axis=1).mean()
    assert 0.02 < changed < 0.7


def test_figure_3_is_drawn_from_camera_ray(scenes: Library) -> None:
    """Where a ray crosses the image plane gives red and green: 0 to 1 across the picture."""
    with scenes.session() as s:
        s.call("setup_scene", 0)
        cam = s.get("theCamera")
        j, i = np.divmod(np.arange(WIDTH * HEIGHT), WIDTH)
        r = s.call_many("camera_ray", i.size, scenes.zeros("ray"), i + 0.5, j + 0.5).args["r"]
    way = r["dir"].astype(float)
    crossing = way / (way @ cam["zdir"])[:, None] * np.linalg.norm(cam["center"])
    red = crossing @ cam["xdir"] * 0.5 + 0.5
    green = crossing @ cam["ydir"] * cam["aspect"] * 0.5 + 0.5
    np.testing.assert_allclose(red, (i + 0.5 - WIDTH / 2) / (WIDTH / 2) * 0.5 + 0.5, atol=1e-6)
    np.testing.assert_allclose(green, (j + 0.5 - HEIGHT / 2) / (HEIGHT / 2) * 0.5 + 0.5, atol=1e-6)
