"""TP3, bonus: checkerboards and textures."""

from __future__ import annotations

from functools import partial

import numpy as np

from grader.authoring.expected.vectors.maker import Maker, Question, Recipe, floats, stack
from grader.authoring.expected.vectors.tp3 import CASES, COPIED, NONE, one
from grader.checking.expected_data import Array, Batch


def recipes() -> list[Recipe]:
    """Return how the suites of the patterns are made."""
    return [*_checkers(), *_textures()]


def _checkers() -> list[Recipe]:
    return [
        Recipe(f"checker_color.{name}", partial(_cubes, *cells, name == "placed"), 1e-5, COPIED)
        # Whether the sign counts is asked of `negative` alone.
        for name, cells in {"positive": (0, 6), "negative": (-6, 0), "placed": (0, 9)}.items()
    ]


def _cubes(low: int, high: int, placed: bool, m: Maker) -> list[Question]:
    """Return points in cubes whose numbers lie between low and high, of side 1 unless placed."""
    cell = m.rng.integers(low, high, (CASES, 3))
    if not placed:
        simple = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)])
        cell[:4] = simple if high > 0 else -1 - simple
    if placed:  # in one layer: a pattern of two directions is placed as well as one of three
        cell[:, 1] = 0
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
    suites = {
        "texel": _texels,
        "sharp": _anywhere,
        "scaled": _globes,
        "seam": _seam,
        "missing": _untextured,
    }
    return [
        Recipe(f"texture_color.{name}", partial(one, make), 1e-4, COPIED)
        for name, make in suites.items()
    ]


def _texels(m: Maker) -> Question:
    return _wrapped(m, SIZE, _to_texels(m, SIZE, 0))


def _anywhere(m: Maker) -> Question:
    return _wrapped(m, SIZE, _to_texels(m, SIZE, 0.4))


def _globes(m: Maker) -> Question:
    size = (3, 7)
    way = _to_texels(m, size, 0)
    way *= m.uniform(0.3, 4, len(way), 1)
    return _wrapped(m, size, way, m.uniform(-2, 2, len(way), 3))


def _seam(m: Maker) -> Question:
    ends = floats([(0, 1, 0), (0, -1, 0), (0, 0, -1), (0, 0.6, -0.8), (0, -0.6, -0.8)])
    return _wrapped(m, SIZE, stack(ends, ends + floats([1e-7, 0, 0])))


def _untextured(m: Maker) -> Question:
    bare = {"mat": m.materials(4, pattern=2), "p": m.unit(4)}
    return Question(Batch("texture_color", bare, m.world()))


SIZE = (5, 8)  # of the texture: rows, columns


def _to_texels(m: Maker, size: tuple[int, int], aside: float) -> Array:
    """Return a direction towards each texel: its middle, or up to a share of it beside."""
    rows, columns = size
    i, j = (each.ravel() for each in np.meshgrid(np.arange(columns), np.arange(rows)))
    middle = 0.5 + aside * m.uniform(-1, 1, 2, len(i))
    around = (i + middle[0] - columns / 2) / columns * 2 * np.pi
    down = (j + middle[1]) / rows * np.pi
    high = np.sin(down)
    return np.stack([np.sin(around) * high, np.cos(down), np.cos(around) * high], axis=1)


def _wrapped(m: Maker, size: tuple[int, int], way: Array, center: Array = NONE) -> Question:
    """Return points at some way from the centre of their sphere."""
    world = {**m.world(), "texels": m.uniform(0.05, 0.95, *size, 3)}
    mat = m.materials(len(way), pattern=2, pattern_origin=center)
    p = (mat["pattern_origin"] + way).astype(np.float32)
    return Question(Batch("texture_color", {"mat": mat, "p": p}, world))
