"""Suites that are said in exercises.toml: for each argument a few numbers, then drawn ones.

    [exercise.suites."reflectance.any"]
    within = 1e-4                             how far right answers may be from the reference's
    why = "a few float operations"            and why
    drawn = 40                                calls, after the first ones
    inputs.n1 = { first = [1, 1.5], low = 1, high = 3 }

Of a struct, fields are said (`inputs.r.dir = { low = [-1, -1, -1], high = [1, 1, 1], unit = true }`
or `inputs.obj.type = "PLANE"`); the others are as an ordinary one has them. A number, a vector or a
constant's name alone is the same in every call.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np

from grader.authoring.expected.vectors.maker import Maker, Question, Recipe, norm1
from grader.build.records import Parameter
from grader.checking.expected_data import Array, Batch, is_written
from grader.course import exercises
from grader.course.exercises import ManifestError

_DRAWN = {"low", "high"}
_WORDS = {"first", "unit"} | _DRAWN


def recipes() -> list[Recipe]:
    """Return how the suites of the manifest are made. Raises ManifestError."""
    said = [each for one in exercises.load().exercises for each in one.suites.items()]
    return [_recipe(name, line) for name, line in said]


def _recipe(name: str, line: Mapping[str, Any]) -> Recipe:
    try:
        return Recipe(name, partial(_questions, name, line), float(line["within"]), line["why"])
    except (KeyError, TypeError, ValueError) as error:
        raise _wrong(name, f"missing or malformed key: {error}") from error


def _questions(name: str, line: Mapping[str, Any], m: Maker) -> list[Question]:
    function = name.partition(".")[0]
    said = line.get("inputs", {})
    parameters = {each.name: each for each in m.core.functions[function].parameters}
    if unknown := sorted(set(said) - {*parameters}):
        raise _wrong(name, f"{function} has no parameter {unknown[0]}")
    count = int(line.get("drawn", 0)) + _longest(said)
    try:
        args = {key: _column(m, each, said.get(key), count) for key, each in parameters.items()}
    except (KeyError, TypeError, ValueError) as error:
        raise _wrong(name, f"its inputs: {error}") from error
    return [Question(Batch(function, args, {}))]


def _longest(said: Any) -> int:
    """Return how many numbers an argument begins with, at most."""
    if not isinstance(said, Mapping):
        return 0
    return max([len(said.get("first", ())), *(_longest(each) for each in said.values())])


def _column(m: Maker, parameter: Parameter, said: Any, count: int) -> Array:
    """Return an argument of every call."""
    ctype = parameter.pointee or parameter.ctype
    if said is None and is_written(parameter.ctype):
        return m.blank(ctype, count)
    made = _ordinary(m, ctype, count)
    if made.dtype.names is None:
        if said is None:
            raise ValueError(f"nothing is said of {parameter.name}")
        return _values(m, made, said)
    _fill(m, made, said or {})
    return made


def _ordinary(m: Maker, ctype: str, count: int) -> Array:
    """Return what an argument is where nothing is said of it."""
    if ctype == "ray":
        return m.rays(np.zeros((count, 3)), (0, 0, -1))
    if ctype == "material":
        return m.materials(count)
    made = m.core.zeros(ctype, count)
    if "mat" in (made.dtype.names or ()):
        made["mat"] = m.materials(count)
    return made


def _fill(m: Maker, made: Array, said: Any) -> None:
    if not isinstance(said, Mapping):
        raise TypeError(f"of a struct its fields are said, such as {(made.dtype.names or '?')[0]}")
    for name, value in said.items():
        if made[name].dtype.names is None:
            made[name] = _values(m, made[name], value)
        else:
            _fill(m, made[name], value)


def _values(m: Maker, like: Array, said: Any) -> Array:
    """Return numbers or vectors, as many as there are in `like`."""
    made = np.zeros_like(like)
    if not isinstance(said, Mapping):
        made[:] = m.core.constants[said] if isinstance(said, str) else said
        return made
    if unknown := sorted(set(said) - _WORDS):
        raise ValueError(f"{unknown[0]} is none of {', '.join(sorted(_WORDS))}")
    if _DRAWN & said.keys():
        drawn = m.rng.uniform(said["low"], said["high"], made.shape)
        made[:] = drawn.round() if made.dtype.kind in "iu" else drawn
    if first := said.get("first"):
        made[: len(first)] = first
    return norm1(made) if said.get("unit") else made


def _wrong(suite: str, problem: str) -> ManifestError:
    return ManifestError(f"exercises.toml: {suite}: {problem}")
