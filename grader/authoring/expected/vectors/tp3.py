"""TP3: Blinn-Phong, the sum of the lights, patterns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from grader.authoring.expected.vectors.maker import (
    Maker,
    Question,
    Recipe,
    floats,
    norm1,
    only,
    stack,
)
from grader.checking.expected_data import Array, Batch

CASES = 120
TOLERANCE = 5e-4
REASON = "a power of up to 200 multiplies the rounding of h.n by 200"
COPIED = "a colour is copied"
UP = floats([[0, 1, 0]])
NONE = floats([0, 0, 0])


def recipes() -> list[Recipe]:
    """Return how the suites of TP3 are made."""
    return [*_shade(), *_direct(), *_checkers(), *_textures()]


# ---- Blinn-Phong --------------------------------------------------------------------------------


def fresnel_at(m: Maker, kr: Array, n: Array, v: Array) -> Array:
    """Return the reference's Fresnel coefficients."""
    asked = m.ask(Batch("fresnel_schlick", {"kr": kr, "n": n, "v": v}, {}))
    return np.asarray(asked.answers[0].result)


def with_fresnel(m: Maker, batch: Batch, mat: Array, n: Array, v: Array, put: Any) -> list[Batch]:
    """Return the calls with Fresnel in the lobe, by h.v and by n.v.

    `put` returns the arguments with other materials in them.
    """
    replaced = mat.copy()
    replaced["ks"] = fresnel_at(m, mat["kr"], n, v)
    on = {**batch.globals, "options": batch.globals["options"].copy()}
    on["options"]["fresnel"] = True
    return [replace(batch, globals=on), replace(batch, args=put(replaced))]


def shading(m: Maker, n: Array, v: Array, light: Array, **fields: Any) -> Question:
    """Return calls of shade without Fresnel; with it they are accepted too."""
    count = len(n)
    mat = m.materials(count, **fields)
    mat["kd"][0] = np.where(mat["kd"][0] > 0, 1, 0)
    mat["ks"][0] = np.where(mat["ks"][0] > 0, 1, 0)
    if "shininess" not in fields:
        mat["shininess"][:3] = 10
    colors = m.uniform(0.3, 2, count, 3)
    colors[:2] = 1
    args = {"n": n, "v": v, "l": light, "light_color": colors, "mat": mat}
    batch = Batch("shade", args, m.world(fresnel=False))
    variants = with_fresnel(m, batch, mat, n, v, lambda changed: {**args, "mat": changed})
    return Question(batch, tuple(variants))


def directions(m: Maker) -> tuple[Array, Array, Array]:
    """Return normals, and directions to the eye and the light on their side; the first is plain."""
    n = stack(UP, UP, UP, m.unit(CASES))
    v = stack(UP, norm1([(0, 1, 0), (0.6, 0.8, 0)]), m.around(n[3:], 0.1))
    light = stack(UP, norm1([(0.8, 0.6, 0), (-0.6, 0.8, 0)]), m.around(n[3:], 0.1))
    return n, v, light


def _shade() -> list[Recipe]:
    suites = {
        "diffuse": _diffuse,
        "lobe": _lobe,
        "both": lambda m: shading(m, *directions(m)),
        "far_lobe": _far_lobe,
        "back": _back,
    }
    return [
        Recipe(f"shade.{name}", partial(_one, make), TOLERANCE, REASON)
        for name, make in suites.items()
    ]


def _one(make: Callable[[Maker], Question], m: Maker) -> list[Question]:
    return [make(m)]


def _diffuse(m: Maker) -> Question:
    return shading(m, *directions(m), ks=NONE, kr=NONE)


def _lobe(m: Maker) -> Question:
    n, _, light = directions(m)
    near = norm1(light + 0.2 * m.unit(len(n)))
    mirrored = norm1(2 * np.einsum("ij,ij->i", near, n)[:, None] * n - near)
    return _facing(shading(m, n, mirrored, light, kd=NONE))


def _far_lobe(m: Maker) -> Question:
    n = directions(m)[0]
    below, grazing = m.around(-n, 0.85, 0.98), m.around(n, 0.05, 0.3)
    return shading(m, n, below, grazing, shininess=floats([2, 4, 3]).repeat(len(n))[: len(n)])


def _back(m: Maker) -> Question:
    n, v, _ = directions(m)
    dark = m.around(-n, 0.02)
    dark[0] = -n[0]
    return shading(m, n, v, dark)


def _facing(question: Question) -> Question:
    """Keep the calls in which the eye is on the light's side."""
    args = question.batch.args
    keep = np.einsum("ij,ij->i", args["n"], args["v"]) > 0.05
    variants = tuple(only(each, keep) for each in question.variants)
    return Question(only(question.batch, keep), variants)


# ---- Several lights -----------------------------------------------------------------------------


def _direct() -> list[Recipe]:
    sets = {"one": _single, "sum": _several, "bright": _bright, "none": _no_light}
    return [
        Recipe(f"direct_light.{name}", partial(_under, make), TOLERANCE, REASON)
        for name, make in sets.items()
    ]


def _under(make: Callable[[Maker], list[Array]], m: Maker) -> list[Question]:
    return [direct(m, lights) for lights in make(m)]


def _single(m: Maker) -> list[Array]:
    drawn = m.lights(m.uniform(-9, 9, 1, 3), [(1, 0.8, 0.5)])
    return [m.lights([(0, 5, 0)], [(1, 1, 1)]), drawn]


def _several(m: Maker) -> list[Array]:
    place = [floats([(0, 5, 0), (5, 5, 0)]), m.uniform(-9, 9, 3, 3), m.uniform(-90, 90, 3, 3)]
    return [m.lights(each, m.uniform(0.2, 0.9, len(each), 3)) for each in place]


def _bright(m: Maker) -> list[Array]:
    return [m.lights([(0, 5, 0), (0, 7, 1)], [(9, 9, 9), (5, 6, 7)])]


def _no_light(m: Maker) -> list[Array]:
    return [m.lights([], ())]


def direct(m: Maker, lights: Array, count: int = 40) -> Question:
    """Return calls of direct_light around lights, with nothing that could throw a shadow."""
    mat = m.materials(count)
    mat["kd"][0], mat["ks"][0], mat["shininess"][0] = 1, 1, 10
    n = stack(UP, m.unit(count - 1))
    position = m.uniform(-2, 2, count, 3)
    position[0] = 0
    if len(lights):  # most of the points look at a light
        to_light = norm1(lights["position"][m.rng.integers(len(lights), size=count)] - position)
        n[1:] = m.around(to_light[1:], 0.1)
        n[count // 2 :: 4] *= -1
    v = m.around(n, 0.1)
    v[0] = UP
    hits = m.hits(position, n, mat)
    batch = Batch("direct_light", {"it": hits, "v": v}, m.world(None, lights, fresnel=False))

    def put(changed: Array) -> dict[str, Array]:
        return {"it": m.hits(position, n, changed), "v": v}

    return Question(batch, tuple(with_fresnel(m, batch, mat, n, v, put)))


# ---- Patterns -----------------------------------------------------------------------------------


def _checkers() -> list[Recipe]:
    return [
        Recipe(f"checker_color.{name}", partial(_cubes, *cells, name == "placed"), 1e-5, COPIED)
        for name, cells in {"positive": (0, 6), "negative": (-6, 0), "placed": (-6, 6)}.items()
    ]


def _cubes(low: int, high: int, placed: bool, m: Maker) -> list[Question]:
    """Return points in cubes whose numbers lie between low and high, of side 1 unless placed."""
    cell = m.rng.integers(low, high, (CASES, 3))
    if not placed:
        simple = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)])
        cell[:4] = simple if high > 0 else -1 - simple
    size = m.uniform(0.2, 2, CASES) if placed else np.ones(CASES, np.float32)
    start = m.uniform(-2, 2, CASES, 3) * placed
    mat = m.materials(CASES, pattern=1, pattern_size=size, pattern_origin=start)
    mat["kd2"] = m.uniform(0.05, 0.95, CASES, 3)
    mat["kd"][:4], mat["kd2"][:4] = 1, 0
    within = m.uniform(0.1, 0.9, CASES, 3)
    within[:4] = 0.5
    p = (start + (cell + within) * size[:, None]).astype(np.float32)
    return [Question(Batch("checker_color", {"mat": mat, "p": p}, {}))]


def _textures() -> list[Recipe]:
    suites = {"texel": _texels, "scaled": _globes, "seam": _seam, "missing": _untextured}
    return [
        Recipe(f"texture_color.{name}", partial(_one, make), 1e-5, COPIED)
        for name, make in suites.items()
    ]


def _texels(m: Maker) -> Question:
    return _wrapped(m, _to_texels(m))


def _globes(m: Maker) -> Question:
    way = _to_texels(m)
    way *= m.uniform(0.3, 4, len(way), 1)
    return _wrapped(m, way, m.uniform(-2, 2, len(way), 3))


def _seam(m: Maker) -> Question:
    ends = floats([(0, 1, 0), (0, -1, 0), (0, 0, -1), (0, 0.6, -0.8), (0, -0.6, -0.8)])
    return _wrapped(m, stack(ends, ends + floats([1e-7, 0, 0])))


def _untextured(m: Maker) -> Question:
    bare = {"mat": m.materials(4, pattern=2), "p": m.unit(4)}
    return Question(Batch("texture_color", bare, m.world()))


ROWS, COLUMNS = 5, 8  # of the texture


def _to_texels(m: Maker) -> Array:
    """Return a direction towards each texel, well inside it."""
    i, j = (each.ravel() for each in np.meshgrid(np.arange(COLUMNS), np.arange(ROWS)))
    around = (i + m.uniform(0.1, 0.9, len(i)) - COLUMNS / 2) / COLUMNS * 2 * np.pi
    down = (j + m.uniform(0.1, 0.9, len(j))) / ROWS * np.pi
    high = np.sin(down)
    return np.stack([np.sin(around) * high, np.cos(down), np.cos(around) * high], axis=1)


def _wrapped(m: Maker, way: Array, center: Array = NONE) -> Question:
    """Return points at some way from the centre of their sphere."""
    world = {**m.world(), "texels": m.uniform(0.05, 0.95, ROWS, COLUMNS, 3)}
    mat = m.materials(len(way), pattern=2, pattern_origin=center)
    p = (mat["pattern_origin"] + way).astype(np.float32)
    return Question(Batch("texture_color", {"mat": mat, "p": p}, world))
