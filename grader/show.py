"""Calls and values as text: what a failure shows of the inputs, in C's own names.

Only what differs from zero, or from what ray_init puts there, is shown.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from grader.expected import Array, Batch

# The fields of an object that its type uses; the union holds nothing else.
OBJECTS = {
    1: ("SPHERE", ("center", "radius")),
    2: ("PLANE", ("normal", "dist")),
    3: ("CYLINDER", ("base", "axis", "length", "radius")),
    4: ("CONE", ("base", "axis", "length", "radius")),
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
_MOST_ITEMS = 4  # of a scene: a longer list says nothing to a reader
# Shown even when zero.
_ALWAYS = (
    *("orig", "dir", "center", "position", "normal", "base", "axis", "dist", "min", "max"),
    *("kd", "ks", "kd2"),
)


def number(value: float) -> str:
    """Return a number as short as it can be told."""
    return f"{value + 0.0:.4g}"  # no -0


def value(item: Any, material: Sequence[str] = ()) -> str:
    """Return the text of a value: a bool, a number, a triple or a struct.

    Of a material only the fields in `material` are shown.
    """
    names = getattr(getattr(item, "dtype", None), "names", None)
    if names:
        return "{" + ", ".join(_fields(item, names, material)) + "}"
    array = np.asarray(item)
    if array.dtype == bool:
        return "true" if array else "false"
    text = ", ".join(number(each) for each in np.ravel(array).astype(np.float64))
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
    """Return the scene and, where they matter, the lights and the options of a batch."""
    lists = ("scene", "lights") if batch.function == "direct_light" else ("scene",)
    parts = []
    for name in lists:
        items = batch.globals.get(name, np.zeros(0))
        if 0 < len(items) <= _MOST_ITEMS:
            parts.append(f"{name}: " + ", ".join(value(each) for each in items))
        elif len(items):
            parts.append(f"{name}: {len(items)}")
    option = _OPTIONS.get(batch.function)
    if option and "options" in batch.globals and not batch.globals["options"][option]:
        parts.append(f"options.{option} = false")
    return f" [{'; '.join(parts)}]" if parts else ""


def complexity(batch: Batch, case: int) -> tuple[int, int, float]:
    """Return how hard a call is to follow: numbers that are not zero, their digits, their size."""
    numbers = [np.ravel(_numbers(column[case])) for column in batch.args.values()]
    flat = np.concatenate([*numbers, np.zeros(1)])
    digits = sum(len(number(each)) for each in flat if each)
    return int(np.count_nonzero(flat)), digits, float(np.abs(flat).sum())


def simplest(batch: Batch, cases: Array) -> int:
    """Return the least complex of these cases; it is quick where there are many."""
    counts = np.zeros(len(cases), int)
    for column in batch.args.values():
        counts += _nonzeros(column[cases])
    fewest = cases[counts == counts.min()]
    return int(min(fewest, key=lambda case: complexity(batch, case)))


def _nonzeros(column: Array) -> Array:
    """Return how many numbers of each item are not zero."""
    names = column.dtype.names
    counts = np.zeros(len(column), int)
    if not names:
        counts += np.count_nonzero(column, axis=tuple(range(1, column.ndim)))
    elif "mat" in names and "type" in names:
        for kind in np.unique(column["type"]):
            chosen = column["type"] == kind
            for name in OBJECTS[int(kind)][1]:
                counts[chosen] += _nonzeros(column[name][chosen])
    else:
        for name in names:
            counts += _nonzeros(column[name])
    return counts


def _numbers(item: Any) -> Any:
    names = getattr(getattr(item, "dtype", None), "names", None)
    if not names:
        return np.asarray(item, np.float64)
    if "mat" in names and "type" in names:
        names = OBJECTS[int(item["type"])][1]
    return np.concatenate([np.ravel(_numbers(item[name])) for name in names])


def _fields(item: Any, names: Iterable[str], material: Sequence[str]) -> list[str]:
    names = tuple(names)
    shown: list[str] = []
    if "mat" in names and "type" in names:
        word, names = OBJECTS[int(item["type"])]
        shown = [word]
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
