"""TP3: Blinn-Phong, the sum of the lights."""

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
    integers,
    norm1,
    only,
    result,
    stack,
)
from grader.checking.expected_data import Array, Batch

CASES = 120
TOLERANCE = 1e-3
REASON = "a power of up to 200 multiplies the rounding of h.n by 200; pi may be 3.14"
COPIED = "a colour is copied"
UP = floats([[0, 1, 0]])
NONE = floats([0, 0, 0])
LOW = 8  # a power that stays finite whatever its base
DIM = 0.95  # of a channel: not limited by who limits colours to 1
FAINT = 0.05  # too little to say how it is wrong


def recipes() -> list[Recipe]:
    """Return how the suites of TP3 are made."""
    return [*_shade(), *_direct()]


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
    colors = m.uniform(0.3, 1, count, 3)
    colors[:2] = 1
    args = {"n": n, "v": v, "l": light, "light_color": colors, "mat": mat}
    batch = Batch("shade", args, m.switches(fresnel=False))
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
        "both": lambda m: shading(m, *directions(m), shininess=LOW),
        "far_lobe": _far_lobe,
        "from_below": _from_below,
        "back": _back,
        "grazing": _grazing,
        "shininess": _between_whole,
    }
    return [
        Recipe(f"shade.{name}", partial(one, make), TOLERANCE, REASON)
        for name, make in suites.items()
    ]


def one(make: Callable[[Maker], Question], m: Maker) -> list[Question]:
    """Return the only question that `make` gives."""
    return [make(m)]


def _diffuse(m: Maker) -> Question:
    return shading(m, *directions(m), ks=NONE, kr=NONE, shininess=LOW)


def _lobe(m: Maker) -> Question:
    n, _, light = directions(m)
    near = norm1(light + 0.2 * m.unit(len(n)))
    mirrored = norm1(2 * np.einsum("ij,ij->i", near, n)[:, None] * n - near)
    return _facing(shading(m, n, mirrored, light, kd=NONE))


def _far_lobe(m: Maker) -> Question:
    n = directions(m)[0]
    below, grazing = m.around(-n, 0.85, 0.98), m.around(n, 0.05, 0.3)
    shininess = np.resize(floats([2, 4, 3, 2.5]), len(n))
    return shading(m, n, below, grazing, kd=NONE, shininess=shininess)


def _from_below(m: Maker) -> Question:
    """Return calls for an eye just below the surface, of which h is above it."""
    n = directions(m)[0]
    below, light = m.around(-n, 0.05, 0.2), m.around(n, 0.7, 0.95)
    return shading(m, n, below, light, kd=NONE, shininess=3)


def _back(m: Maker) -> Question:
    n, v, _ = directions(m)
    dark = m.around(-n, 0.02)
    dark[0] = -n[0]
    return shading(m, n, v, dark)


def _between_whole(m: Maker) -> Question:
    """Return three calls each time: a power, half more, and one more, which may not be whole."""
    count = 30
    n = np.repeat(m.unit(count), 3, axis=0)
    half = np.repeat(m.around(n[::3], 0.5, 0.8), 3, axis=0)
    light = np.repeat(m.around(half[::3], 0.9), 3, axis=0)
    v = norm1(2 * np.einsum("ij,ij->i", half, light)[:, None] * half - light)
    keep = np.repeat(np.einsum("ij,ij->i", n, light)[::3] > 0.2, 3)
    first = np.repeat(np.resize(floats([2, 0.01, 3, 0.7]), count), 3)
    shininess = first + np.tile(floats([0, 0.5, 1]), count)
    question = shading(m, n, v, light, kd=NONE, ks=1, kr=0.5, shininess=shininess)
    question.batch.args["light_color"][:] = 1
    return Question(only(question.batch, keep))


def _grazing(m: Maker) -> Question:
    n, v, _ = directions(m)
    v[1::2] *= -1  # where the eye is does not matter
    return shading(m, n, v, m.around(n, 0.01, 0.1))


def _facing(question: Question) -> Question:
    """Keep the calls in which the eye is on the light's side."""
    args = question.batch.args
    keep = np.einsum("ij,ij->i", args["n"], args["v"]) > 0.05
    variants = tuple(only(each, keep) for each in question.variants)
    return Question(only(question.batch, keep), variants)


# ---- Several lights -----------------------------------------------------------------------------


def _direct() -> list[Recipe]:
    sets = {"one": _single, "sum": _several, "bright": _bright, "none": _no_light}
    made = [
        Recipe(f"direct_light.{name}", partial(_under, make), TOLERANCE, REASON)
        for name, make in sets.items()
    ]
    barred = Recipe("direct_light.barred", _behind_a_ball, TOLERANCE, REASON)
    beyond = Recipe("direct_light.count", _beyond, TOLERANCE, REASON)
    behind = Recipe("direct_light.behind", _from_behind, TOLERANCE, REASON)
    return [*made, barred, beyond, behind]


def _under(make: Callable[[Maker], list[Array]], m: Maker) -> list[Question]:
    return [direct(m, lights) for lights in make(m)]


def _single(m: Maker) -> list[Array]:
    drawn = m.lights(m.uniform(-9, 9, 1, 3), [(1, 0.8, 0.5)])
    far = m.lights([(-200, 170, 300)], [(1, 1, 1)])
    return [m.lights([(0, 5, 0)], [(1, 1, 1)]), drawn, far]


def _several(m: Maker) -> list[Array]:
    place = [floats([(0, 5, 0), (5, 5, 0)]), m.uniform(-9, 9, 3, 3), m.uniform(-15, 15, 3, 3)]
    return [m.lights(each, m.uniform(0.1, 0.4, len(each), 3)) for each in place]


def _bright(m: Maker) -> list[Array]:
    return [m.lights([(0, 5, 0), (0, 7, 1)], [(9, 9, 9), (5, 6, 7)])]


def _no_light(m: Maker) -> list[Array]:
    return [m.lights([], ())]


def _beyond(m: Maker) -> list[Question]:
    """Return lights of which the last ones do not count any more."""
    made = []
    for count in (1, 2):
        lights = m.lights([(0, 5, 0), (4, 5, 1), (-3, 6, 2)], [(1, 1, 1)] * 3)
        batch = direct(m, lights).batch
        made.append(
            Question(replace(batch, globals={**batch.globals, "num_lights": integers(count)}))
        )
    return made


def _behind_a_ball(m: Maker) -> list[Question]:
    """Return two lights, of which a sphere bars the first: alone, then the second by itself."""
    count = 12
    position = m.uniform(-0.3, 0.3, count, 3)
    position[0] = 0
    position[:, 1] -= 3
    lights = m.lights([(0, 5, 0), (-8, 2, 0)], [(1, 1, 1), (6, 5, 4)])
    n = np.tile(UP, (count, 1))
    hits = m.hits(position, n, m.materials(count))
    ball = m.objects("SPHERE", 1, center=(0, 0, 0), radius=1)
    return [
        Question(Batch("direct_light", {"it": hits, "v": n}, m.world(ball, each, fresnel=False)))
        for each in (lights, lights[1:])
    ]


def _from_behind(m: Maker) -> list[Question]:
    """Return points of which the eye sees the other side, as from within a ball of glass.

    Where it looks straight at the light there is no h.
    """
    made = direct(m, m.lights([(0, 5, 0)], [(1, 1, 1)]), side=-1)
    args = made.batch.args
    to_light = norm1(floats([0, 5, 0]) - args["it"]["position"])
    keep = np.linalg.norm(args["v"] + to_light, axis=1) > 0.3
    return [Question(only(made.batch, keep), tuple(only(each, keep) for each in made.variants))]


def direct(m: Maker, lights: Array, count: int = 40, side: int = 1) -> Question:
    """Return calls of direct_light around lights, with nothing that could throw a shadow.

    The eye is on the normal's side, or with `side` -1 on the other.
    """
    mat = m.materials(count, shininess=m.uniform(1, 20, count).round())
    mat["kd"][0], mat["ks"][0], mat["shininess"][0] = 1, 1, 10
    n = stack(UP, m.unit(count - 1))
    position = m.uniform(-2, 2, count, 3)
    position[0] = 0
    if len(lights):  # most of the points look at a light
        to_light = norm1(lights["position"][m.rng.integers(len(lights), size=count)] - position)
        n[1:] = m.around(to_light[1:], 0.1)
        n[count // 2 :: 4] *= -1
    v = m.around(side * n, 0.1)
    v[0] = UP if side > 0 else (0.6, -0.8, 0)
    hits = m.hits(position, n, mat)
    far = m.objects("SPHERE", 1, center=(0, 900, 0), radius=0.1)
    world = m.world(far, lights, fresnel=False, shadows=False)
    batch = Batch("direct_light", {"it": hits, "v": v}, world)
    most = result(m.ask(batch)).max(axis=1)
    clear = (most == 0) | (most > FAINT)

    def put(changed: Array) -> dict[str, Array]:
        return {"it": m.hits(position, n, changed), "v": v}

    variants = with_fresnel(m, batch, mat, n, v, put)
    bright = len(lights) and lights["col"].max() > 1
    keep = clear if bright else clear & (most < DIM)
    return Question(only(batch, keep), tuple(only(each, keep) for each in variants))
