"""Values as C that sets them: the same floats are read back, and only what is unusual is told."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from grader.checking import describe
from grader.checking.expected_data import Array
from grader.intake.header_numbers import header_number, kinds

# What the program's globals are before it sets them.
_OPTIONS = {"samples": 1, "max_depth": 10, "epsilon": "EPSILON"}
_RAY = {"tmin": 0, "tmax": "RAY_TMAX", "depth": 0, "seed": 1}


def number(item: Any) -> str:
    """Return a C literal that is read back as the same number."""
    if isinstance(item, (bool, np.bool_)):
        return "true" if item else "false"
    if isinstance(item, (int, np.integer)):
        return str(int(item))
    if np.isnan(item):
        return "NAN"
    if np.isinf(item):
        return "INFINITY" if item > 0 else "-INFINITY"
    text = repr(float(str(np.float32(item))))  # the shortest that is that float
    return f"{text.removesuffix('0') if text.endswith('.0') else text}f"


def vector(item: Any) -> str:
    """Return a vector from three numbers."""
    return f"vector_init({', '.join(number(np.float32(each)) for each in item)})"


def short(item: Any) -> Array:
    """Return a vector of no more digits than a report shows."""
    return np.array([float(describe.number(each)) for each in item], np.float32)


def literal(item: Any) -> str:
    """Return a parameter: a vector, a number of the type that numpy gives it, else a float."""
    array = np.asarray(item)
    if array.ndim:
        return vector(array)
    whole = array.dtype.kind in "biu" and not isinstance(item, int)
    return number(array[()]) if whole else number(np.float32(item))


def kind(item: Any) -> str:
    """Return the C type of a number."""
    return {"b": "bool", "i": "int", "u": "int"}.get(item.dtype.kind, "float")


def _usual(table: Mapping[str, Any], field: str) -> Any:
    """Return what a field is at the start: a number, one that the headers have, or else true."""
    said = table.get(field, True)
    return np.float32(header_number(said)) if isinstance(said, str) else said


def ray(name: str, item: Any, is_seeded: bool) -> Iterator[str]:
    """Yield a ray's declaration, then the fields that ray_init leaves otherwise."""
    yield f"ray {name};"
    yield f"ray_init(&{name}, {vector(item['orig'])}, {vector(item['dir'])});"
    for field in _RAY:
        if item[field] != _usual(_RAY, field) and (is_seeded or field != "seed"):
            yield f"{name}.{field} = {number(item[field])};"


def solid(item: Any, mat: str) -> str:
    """Return the construction of an object of the material of that name."""
    word = kinds()[int(item["type"])]
    fields = describe.OBJECTS[word]
    parts = [literal(item[each]) for each in fields]
    if word in ("SPHERE", "PLANE"):  # their vector goes by its components
        first, second = (item[each] for each in fields)
        parts = [number(each) for each in (*first, second)]
    return f"init_{word.lower()}({', '.join([*parts, mat])})"


def material(name: str, item: Any, fields: Sequence[str]) -> Iterator[str]:
    """Yield a material's declaration, then those fields that init_material leaves otherwise."""
    three = f"{vector(item['kd'])}, {vector(item['ks'])}, {number(item['shininess'])}"
    yield f"material {name} = init_material({three});"
    usual = {"kr": item["ks"]}
    for field in dict.fromkeys(fields):
        if field == "user":
            for k in np.flatnonzero(item["user"]):
                yield f"{name}.user[{k}] = {number(item['user'][k])};"
        elif np.any(item[field] != usual.get(field, 0)):
            yield f"{name}.{field} = {literal(item[field])};"


def camera(item: Any) -> str:
    """Return the construction of a camera."""
    at = item["position"] + item["zdir"]
    parts = [*map(vector, (item["position"], at, item["ydir"]))]
    return f"init_camera({', '.join([*parts, number(item['fov']), number(item['aspect'])])})"


def options(item: Any, fields: Sequence[str] = ()) -> Iterator[str]:
    """Yield those fields (or all) of `options` that are not as at the start."""
    for field in fields or item.dtype.names:
        if item[field] != _usual(_OPTIONS, field):
            yield f"options.{field} = {number(item[field][()])};"


def settings(values: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield what sets each option that is not as at the start: in C, and for ./mrt."""
    for name, value in values.items():
        if name not in _OPTIONS and not value:
            yield f"options.{name} = false;", f"--no-{name}"
        elif name in _OPTIONS and value != _usual(_OPTIONS, name):
            text = number(np.float32(value) if name == "epsilon" else value)
            yield f"options.{name} = {text};", f"--{name.replace('_', '-')} {text.rstrip('f')}"


def texture(texels: Array) -> Iterator[str]:
    """Yield what sets scene_texture to colours, shape (height, width, 3)."""
    height, width = texels.shape[:2]
    yield "static color texels[] = {"
    for row in texels.reshape(-1, 3):
        yield f"    {{{', '.join(number(each) for each in row)}}},"
    yield "};"
    yield f"scene_texture.width = {width};"
    yield f"scene_texture.height = {height};"
    yield "scene_texture.texels = texels;"
