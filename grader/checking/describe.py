"""Calls and values as text: what a failure shows of the inputs, in C's own names.

Only what differs from zero, or from what ray_init puts there, is shown.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from grader.checking.expected_data import SIZE, Array, Batch, counted
from grader.intake.header_numbers import kinds

# The fields of an object that its type uses; the union holds nothing else.
OBJECTS = {
    "SPHERE": ("center", "radius"),
    "PLANE": ("normal", "dist"),
    "CYLINDER": ("base", "axis", "length", "radius"),
    "CONE": ("base", "axis", "length", "radius"),
}
_RAY_DEFAULTS = {"tmin": 0.0, "tmax": 1000.0, "depth": 0}
# What is worth knowing of a material, by the function that reads it; of other functions, nothing.
_LIGHTING = ("kd", "ks", "shininess", "kr")
_MATERIALS = {
    "shade": _LIGHTING,
    "direct_light": _LIGHTING,
    "checker_color": ("kd", "kd2", "pattern_origin", "pattern_size"),
    "texture_color": ("kd", "pattern_origin"),
    "mirror_color": ("ks", "kr"),
    "refracted_ray": ("refraction_index",),
    "glass_color": ("refraction_index",),
}
# The options that matter, likewise.
_OPTIONS = {
    "shade": "fresnel",
    "direct_light": "fresnel",
    "mirror_color": "fresnel",
    "trace_ray": "shading",
    "pixel_color": "shading",
}
# What depends on the picture's size and on the camera.
_PICTURES = ("camera_ray", "raytrace", "pixel_color")
_COUNTS = {"scene": "object_count", "lights": "num_lights"}
DIGITS, FLOAT_DIGITS = 4, 9  # that are shown; that tell any two floats apart
ALIKE = 1e-5  # share of the largest component: what differs by less is rounding
_MOST_ITEMS = 4  # of a scene: a longer list says nothing to a reader
# Shown even when zero.
_ALWAYS = (
    *("orig", "dir", "center", "position", "normal", "base", "axis", "dist", "min", "max"),
    *("kd", "ks", "kd2"),
)


def number(value: float, digits: int = DIGITS) -> str:
    """Return a number as short as it can be told."""
    return f"{value + 0.0:.{digits}g}"  # no -0


def pair(got: Any, expected: Any) -> dict[str, str]:
    """Return the texts of what came and of what is expected, with digits enough to tell them apart.

    Every component that differs does so in its text, as far as a float goes.
    """
    sides = [np.ravel(np.asarray(each)) for each in (got, expected)]
    digits = DIGITS
    while digits < FLOAT_DIGITS and _look_alike(sides, digits):
        digits += 1
    return {"got": value(got, digits=digits), "expected": value(expected, digits=digits)}


def _look_alike(sides: Sequence[Array], digits: int) -> bool:
    """Say whether components that differ, by more than rounding, have the same text."""
    if any(each.dtype.names or each.dtype.kind not in "fiu" for each in sides):
        return False
    got, expected = (each.astype(np.float64) for each in sides)
    if got.shape != expected.shape:
        return False
    size = np.nan_to_num(np.abs(expected).max(initial=0.0))
    far_apart = np.abs(got - expected) > ALIKE * max(size, ALIKE)
    return any(
        number(a, digits) == number(b, digits)
        for a, b in zip(got[far_apart], expected[far_apart], strict=True)
    )


def value(item: Any, material: Sequence[str] = (), digits: int = DIGITS) -> str:
    """Return the text of a value: a bool, a number, a triple or a struct.

    Of a material only the fields in `material` are shown. A whole number has all its digits.
    """
    names = getattr(getattr(item, "dtype", None), "names", None)
    if names:
        return "{" + ", ".join(_fields(item, names, material)) + "}"
    array = np.asarray(item)
    if array.dtype == bool:
        return "true" if array else "false"
    flat = np.ravel(array)
    if flat.dtype.kind in "iu":
        text = ", ".join(str(each) for each in flat)
    else:
        text = ", ".join(number(each, digits) for each in flat.astype(np.float64))
    return f"({text})" if array.size > 1 else text


def call(batch: Batch, case: int, hidden: Sequence[str] = ()) -> str:
    """Return call number `case` of a batch; parameters that are only written are `hidden`."""
    material = _MATERIALS.get(batch.function, ())
    if "options" in batch.globals and not batch.globals["options"]["fresnel"]:
        material = tuple(name for name in material if name != "kr")
    parts = []
    for name, column in batch.args.items():
        shown = f"{name} = {value(column[case], material)}"
        parts.append(name if name in hidden else shown)
    return f"{batch.function}({', '.join(parts)}){setting(batch)}"


def setting(batch: Batch) -> str:
    """Return what a batch is run in, in C's own names, which need no language.

    The scene, or how long it is; where they matter the picture's size, the camera, the lights and
    the options.
    """
    lists = ("scene", "lights") if batch.function == "direct_light" else ("scene",)
    parts = [*_picture(batch)] if batch.function in _PICTURES else []
    for name in lists:
        items = batch.globals.get(name, np.zeros(0))[: counted(batch.globals, name)]
        if 0 < len(items) <= _MOST_ITEMS:
            parts.append(f"{name}: " + ", ".join(value(each) for each in items))
        elif len(items):
            parts.append(f"{_COUNTS[name]} = {len(items)}")
    option = _OPTIONS.get(batch.function)
    if option and "options" in batch.globals and not batch.globals["options"][option]:
        parts.append(f"options.{option} = false")
    return f" [{'; '.join(parts)}]" if parts else ""


def _picture(batch: Batch) -> Iterator[str]:
    """Yield the size of the picture, the camera and the samples of a batch."""
    width, height = SIZE
    yield f"WIDTH = {width}, HEIGHT = {height}"
    if "theCamera" in batch.globals:
        yield f"theCamera: {value(batch.globals['theCamera'])}"
    samples = int(batch.globals["options"]["samples"]) if "options" in batch.globals else 1
    if samples != 1:
        yield f"options.samples = {samples}"


def complexity(batch: Batch, case: int) -> tuple[int, int, float]:
    """Return how hard a call is to follow: numbers that are not zero, their digits, their size."""
    flat = _rows(batch, np.array([case]))[0]
    flat = flat[flat != 0]
    return len(flat), sum(len(number(each)) for each in flat), float(np.abs(flat).sum())


def simplest(batch: Batch, cases: Array) -> int:
    """Return the least complex of these cases; it is quick where there are many."""
    counts = np.count_nonzero(_rows(batch, cases), axis=1)
    fewest = cases[counts == counts.min()]
    return int(min(fewest, key=lambda case: complexity(batch, case)))


def _rows(batch: Batch, cases: Array) -> Array:
    """Return the numbers of calls, a row each."""
    return np.hstack([_numbers(column[cases]) for column in batch.args.values()])


def _numbers(column: Array) -> Array:
    """Return the numbers of each item, a row each; what an object's type does not use is 0."""
    names = column.dtype.names
    if not names:
        return column.astype(np.float64).reshape(len(column), -1)
    parts = {name: _numbers(column[name]) for name in names}
    if "mat" in names and "type" in names:
        for name, part in parts.items():
            users = [kind for kind, word in kinds().items() if name in OBJECTS[word]]
            part[~np.isin(column["type"], users)] = 0
    return np.hstack([*parts.values()])


def _fields(item: Any, names: Iterable[str], material: Sequence[str]) -> list[str]:
    names = tuple(names)
    shown: list[str] = []
    if "mat" in names and "type" in names:
        word = kinds()[int(item["type"])]
        names, shown = OBJECTS[word], [word]
    if "shininess" in names:
        names = tuple(material)
    for name in names:
        default = _RAY_DEFAULTS.get(name, 0.0) if "orig" in names else 0.0
        part = item[name]
        if name == "seed" or (name == "mat" and not material):
            continue
        if part.dtype.names or name in _ALWAYS or np.any(part != default):
            shown.append(f"{name} {value(part, material)}")
    return shown
