"""TP5: Fresnel, samples, the fractal."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from grader.authoring.expected.vectors import mirrors, tp3
from grader.authoring.expected.vectors.maker import (
    Maker,
    Question,
    Recipe,
    floats,
    integers,
    norm1,
    stack,
)
from grader.authoring.expected.vectors.tp2 import COLOR, COLOR_REASON
from grader.checking.expected_data import SIZE, Array, Batch

CASES = 100
TOLERANCE = 1e-4
REASON = "a few float operations; the fifth power may be made by powf"
DRAWS = 400  # of glass_color for each angle


def recipes() -> list[Recipe]:
    """Return how the suites of TP5 are made."""
    return [
        *_schlick(),
        Recipe("fresnel_use.lobe", _in_the_lobe, tp3.TOLERANCE, tp3.REASON),
        Recipe("fresnel_use.mirror", _in_the_mirror, COLOR, COLOR_REASON),
        *_samples(),
        Recipe("populate_spheres.any", _fractal, 1e-3, "a few float operations a generation"),
    ]


# ---- Fresnel ------------------------------------------------------------------------------------


def _schlick() -> list[Recipe]:
    views = {"normal": lambda m, n: n, "grazing": _across, "angle": _aslant, "negative": _behind}
    return [
        Recipe(f"fresnel_schlick.{name}", partial(_viewed, view), TOLERANCE, REASON)
        for name, view in views.items()
    ]


def _viewed(view: Callable[[Maker, Array], Array], m: Maker) -> list[Question]:
    n = m.unit(CASES)
    n[:3] = (0, 1, 0)
    kr = m.uniform(0.02, 0.9, CASES, 3)
    kr[0] = 0.5
    if view is _across:  # what reflects nothing from the front does so along itself
        kr[3::8], kr[5::8, 0] = 0, 0
    return [Question(Batch("fresnel_schlick", {"kr": kr, "n": n, "v": view(m, n)}, {}))]


def _across(m: Maker, n: Array) -> Array:
    return _starting((1, 0, 0), norm1(np.cross(n, m.unit(len(n)))))


def _aslant(m: Maker, n: Array) -> Array:
    return _starting((0.96, 0.28, 0), m.around(n, 0.05, 0.95))


def _behind(m: Maker, n: Array) -> Array:
    return _starting((0, -1, 0), -m.around(n, 0.1))


def _starting(first: tuple[float, float, float], vectors: Array) -> Array:
    vectors[0] = first
    return vectors


def _in_the_lobe(m: Maker) -> list[Question]:
    n, v, light = tp3.directions(m)
    near = tp3.shading(m, n, v, light)
    args = near.batch.args
    # A wide lobe, so that the coefficient counts in every case.
    args["mat"]["shininess"], args["mat"]["kd"][:2] = m.uniform(1, 9, len(n)).round(), 0
    args["mat"]["ks"][4::5] = 0
    on = replace(near.batch, globals=m.world(fresnel=True))

    def put(changed: Array) -> dict[str, Array]:
        return {**args, "mat": changed}

    by_normal = tp3.with_fresnel(m, near.batch, args["mat"], n, v, put)[1]
    return [Question(on, (by_normal,))]


def _in_the_mirror(m: Maker) -> list[Question]:
    sky = mirrors.mirrors(m, m.core.zeros("object", 0), 60)
    sky.args["it"]["mat"]["kr"][:30] *= 0.1
    sky.args["it"]["mat"]["ks"][2::5] = 0
    sky.args["in"]["depth"] = np.arange(sky.count) % 5
    return [mirrors.staged(m, sky, on=True)]


# ---- Samples ------------------------------------------------------------------------------------


SHARES = [(n, k, upright) for n in (2, 3, 4) for k in range(1, n) for upright in (False, True)]


def _samples() -> list[Recipe]:
    edges = {
        "uniform": ([(2, 0, False), (3, 0, True)], 0.9),
        "mean": ([(1, 0, True), *SHARES], 0.9),
        "clamped": (SHARES, 5.0),
    }
    reason = (
        "a square is 0.05 of contrast at least; a plane seen along itself, where the options are"
        " ignored, mirrors the sky by a share that changes across the pixel"
    )
    return [
        *(
            Recipe(f"pixel_color.{name}", partial(_edges, *each), 0.03, reason)
            for name, each in edges.items()
        ),
        Recipe("pixel_color.spread", _corners, 0.03, reason),
        Recipe("pixel_color.seeds", _through_glass, 0.03, "a share of random draws"),
    ]


def _edges(shares: list[tuple[int, int, bool]], red: float, m: Maker) -> list[Question]:
    return [_edge(m, n, k, upright, red) for n, k, upright in shares]


def _edge(m: Maker, samples: int, covered: int, upright: bool, red: float) -> Question:
    """Return pixels cut by the straight edge of a plane that passes just below the eye.

    The plane covers a share `covered` / `samples` of pixel (i, j); the rest is sky.
    """
    i, j = _pixel(m)
    share = covered / samples
    plane, lamp = _half(m, i + share if upright else j + share, upright, 1, red)
    settings = {**m.world(plane, lamp), "theCamera": _upright(m)}
    others = (1, 0) if upright else (0, 1)
    columns = integers([i, i + others[0], i - others[0]])
    rows = integers([j, j + others[1], j - others[1]])
    return _sampled(m, Batch("pixel_color", {"i": columns, "j": rows}, settings), samples)


def _pixel(m: Maker) -> tuple[int, int]:
    return int(m.rng.integers(8, SIZE[0] - 8)), int(m.rng.integers(8, SIZE[1] - 8))


def _upright(m: Maker) -> Array:
    """Return a camera with the image plane at 1 from the eye."""
    return m.camera((0, 0, 0), (0, 0, -1), 90, SIZE[0] / SIZE[1])


def _half(m: Maker, at: float, upright: bool, side: int, red: float) -> tuple[Array, Array]:
    """Return a plane that covers what is left of column `at`, or below that row, and its lamp.

    With side -1 it covers the rest.
    """
    (width, height), camera = SIZE, _upright(m)
    # Where the edge crosses the image plane, along xdir or ydir.
    if upright:
        place, along = (at - width / 2) / (width / 2), camera["xdir"]
    else:
        place, along = (at - height / 2) / (height / 2) / (width / height), camera["ydir"]
    normal = side * norm1(along - place * camera["zdir"])
    # Lit from above so that it is of about the same colour with shading as without.
    mat = m.materials(1, kd=(red, 0.9, 0.1), ks=0, kr=0, shininess=500)
    plane = m.objects("PLANE", 1, mat, normal=normal, dist=1e-3)
    return plane, m.lights([normal * np.float32(100)], np.pi)


def _sampled(m: Maker, batch: Batch, samples: int) -> Question:
    question = m.stages(batch)
    for each in (question.batch, *question.variants):
        each.globals["options"]["samples"] = samples
    return question


def _corners(m: Maker) -> list[Question]:
    """Return pixels of which two planes cover all but a square in a corner, by squares per side.

    Beside it in each batch, a pixel that is covered and one that is not.
    """
    corners = [(2, 1, 1), (2, 1, -1), (2, -1, 1), (2, -1, -1), (3, 1, 1)]
    made = []
    for samples, right, up in corners:
        i, j = _pixel(m)
        share = 1 - 1 / samples - 0.01  # so that a sample at a square's corner is in the square
        halves = [
            _half(m, place + (share if side > 0 else 1 / samples - 0.01), upright, side, 0.9)
            for place, upright, side in ((i, True, right), (j, False, up))
        ]
        planes = stack(*(plane for plane, _ in halves))
        planes["dist"] = 0.02  # far from each other, beside where bounced rays start
        # One lamp that sees both: what lies in the other's shadow is another exercise's question.
        above = norm1(planes["normal"].sum(axis=0))
        lamp = m.lights([above * np.float32(1e4)], np.pi / (planes["normal"][0] @ above))
        settings = {**m.world(planes, lamp), "theCamera": _upright(m)}
        columns, rows = integers([i, i - 2 * right, i + 2 * right]), integers([j, j, j + 2 * up])
        made.append(_sampled(m, Batch("pixel_color", {"i": columns, "j": rows}, settings), samples))
    return made


def _through_glass(m: Maker) -> list[Question]:
    """Return pixels that see a pane of glass aslant: the sky in it, or black behind it."""
    pane = m.objects("PLANE", 1, normal=(0, 1, 0), dist=0)
    pane["mat"] = m.materials(1, kd=0, ks=0, kr=0, refraction_index=1.5)
    floor = m.objects("PLANE", 1, normal=(0, 1, 0), dist=3)
    floor["mat"] = m.materials(1, kd=0, ks=0, kr=0)
    camera = m.camera((0, 1, 0), (9, 0, 0), 20, SIZE[0] / SIZE[1])
    world = {**m.world(stack(pane, floor), samples=3), "theCamera": camera}
    i, j = m.rng.integers(20, SIZE[0] - 20, 24), m.rng.integers(20, 40, 24)
    return [Question(Batch("pixel_color", {"i": integers(i), "j": integers(j)}, world))]


# ---- The fractal --------------------------------------------------------------------------------


def _fractal(m: Maker) -> list[Question]:
    depth = integers([0, 1, 2, 3, 4])
    up = stack(floats([(0, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 0)]), m.unit(1))
    center, radius = m.uniform(-2, 2, 5, 3), m.uniform(0.5, 2, 5)
    center[:3], radius[:3] = 0, 1
    args = {"center": center, "radius": radius, "up": up, "depth": depth}
    return [Question(Batch("populate_spheres", args, m.world()))]
