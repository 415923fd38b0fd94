"""TP3: Blinn-Phong, the sum of the lights, patterns."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from grader.authoring.expected.vectors.maker import (
    Maker,
    Question,
    Suite,
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


def suites(m: Maker) -> list[Suite]:
    """Return the suites of TP3."""
    return [*_shade(m), *_direct(m), *_checkers(m), *_textures(m)]


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


def _shade(m: Maker) -> list[Suite]:
    n, v, light = directions(m)
    none = np.zeros(3, np.float32)
    near = norm1(light + 0.2 * m.unit(len(n)))
    mirrored = norm1(2 * np.einsum("ij,ij->i", near, n)[:, None] * n - near)
    below = m.around(-n, 0.85, 0.98)
    grazing = m.around(n, 0.05, 0.3)
    shininess = floats([2, 4, 3]).repeat(len(n))[: len(n)]
    dark = m.around(-n, 0.02)
    dark[0] = -n[0]
    named = {
        "diffuse": shading(m, n, v, light, ks=none, kr=none),
        "lobe": shading(m, n, mirrored, light, kd=none),
        "both": shading(m, n, v, light),
        "far_lobe": shading(m, n, below, grazing, shininess=shininess),
        "back": shading(m, n, v, dark),
    }
    kept = _facing(named["lobe"])
    named["lobe"] = kept
    return [Suite(f"shade.{name}", (each,), TOLERANCE, REASON) for name, each in named.items()]


def _facing(question: Question) -> Question:
    """Keep the calls in which the eye is on the light's side."""
    args = question.batch.args
    keep = np.einsum("ij,ij->i", args["n"], args["v"]) > 0.05
    variants = tuple(only(each, keep) for each in question.variants)
    return Question(only(question.batch, keep), variants)


# ---- Several lights -----------------------------------------------------------------------------


def _direct(m: Maker) -> list[Suite]:
    one = [m.lights([(0, 5, 0)], [(1, 1, 1)]), m.lights(m.uniform(-9, 9, 1, 3), [(1, 0.8, 0.5)])]
    place = [floats([(0, 5, 0), (5, 5, 0)]), m.uniform(-9, 9, 3, 3), m.uniform(-90, 90, 3, 3)]
    many = [m.lights(each, m.uniform(0.2, 0.9, len(each), 3)) for each in place]
    bright = [m.lights([(0, 5, 0), (0, 7, 1)], [(9, 9, 9), (5, 6, 7)])]
    named = {"one": one, "sum": many, "bright": bright, "none": [m.lights([], ())]}
    return [
        Suite(
            f"direct_light.{name}",
            tuple(direct(m, lights) for lights in sets),
            TOLERANCE,
            REASON,
        )
        for name, sets in named.items()
    ]


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


def _checkers(m: Maker) -> list[Suite]:
    cells = {
        "positive": m.rng.integers(0, 6, (CASES, 3)),
        "negative": m.rng.integers(-6, 0, (CASES, 3)),
        "placed": m.rng.integers(-6, 6, (CASES, 3)),
    }
    simple = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)])
    cells["positive"][:4], cells["negative"][:4] = simple, -1 - simple
    made = []
    for name, cell in cells.items():
        size = m.uniform(0.2, 2, CASES) if name == "placed" else np.ones(CASES, np.float32)
        start = m.uniform(-2, 2, CASES, 3) * (name == "placed")
        mat = m.materials(CASES, pattern=1, pattern_size=size, pattern_origin=start)
        mat["kd2"] = m.uniform(0.05, 0.95, CASES, 3)
        mat["kd"][:4], mat["kd2"][:4] = 1, 0
        within = m.uniform(0.1, 0.9, CASES, 3)
        within[:4] = 0.5
        p = (start + (cell + within) * size[:, None]).astype(np.float32)
        question = Question(Batch("checker_color", {"mat": mat, "p": p}, {}))
        made.append(Suite(f"checker_color.{name}", (question,), 1e-5, COPIED))
    return made


def _textures(m: Maker) -> list[Suite]:
    height, width = 5, 8
    world = {**m.world(), "texels": m.uniform(0.05, 0.95, height, width, 3)}
    i, j = (each.ravel() for each in np.meshgrid(np.arange(width), np.arange(height)))
    around = (i + m.uniform(0.1, 0.9, len(i)) - width / 2) / width * 2 * np.pi
    down = (j + m.uniform(0.1, 0.9, len(j))) / height * np.pi
    high = np.sin(down)
    d = np.stack([np.sin(around) * high, np.cos(down), np.cos(around) * high], axis=1)
    ends = floats([(0, 1, 0), (0, -1, 0), (0, 0, -1), (0, 0.6, -0.8), (0, -0.6, -0.8)])
    seam = stack(ends, ends * floats([1, 1, 1]) + floats([1e-7, 0, 0]))
    named = {"texel": d, "scaled": d * m.uniform(0.3, 4, len(d), 1), "seam": seam}
    made = []
    for name, way in named.items():
        mat = m.materials(len(way), pattern=2)
        if name == "scaled":
            mat["pattern_origin"] = m.uniform(-2, 2, len(way), 3)
        p = (mat["pattern_origin"] + way).astype(np.float32)
        question = Question(Batch("texture_color", {"mat": mat, "p": p}, world))
        made.append(Suite(f"texture_color.{name}", (question,), 1e-5, COPIED))
    bare = {"mat": m.materials(4, pattern=2), "p": m.unit(4)}
    missing = Question(Batch("texture_color", bare, m.world()))
    return [Suite("texture_color.missing", (missing,), 1e-5, COPIED), *made]
