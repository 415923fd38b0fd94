"""Random rays, objects and garbage, always the same ones."""

from __future__ import annotations

import numpy as np

from grader.execution.session import Library, Session
from grader.tests.core.oracles import Array, unit

TYPES = {"sphere": "SPHERE", "plane": "PLANE", "cylinder": "CYLINDER", "cone": "CONE"}


def directions(rng: np.random.Generator, count: int) -> Array:
    """Return unit vectors, uniform on the sphere."""
    return unit(rng.normal(size=(count, 3)))


def materials(core: Library, rng: np.random.Generator, count: int) -> Array:
    """Return opaque materials without pattern: random colours, shininess from 0 to 500."""
    mat = core.zeros("material", count)
    for name in ("kd", "ks", "kr", "kd2", "user"):
        mat[name] = rng.random(mat[name].shape)
    mat["shininess"] = rng.choice([0, 0.01, 1, 20, 200, 500], count)
    mat["pattern_size"] = 1
    return mat


def objects(core: Library, rng: np.random.Generator, kind: str, count: int) -> Array:
    """Return objects of one type around the origin, sizes from 0.1 to 2, planes within 3."""
    obj = core.zeros("object", count)
    obj["type"] = core.constants[TYPES[kind]]
    obj["mat"] = materials(core, rng, count)
    if kind == "plane":
        obj["normal"] = directions(rng, count)
        obj["dist"] = rng.uniform(-3, 3, count)
        return obj
    obj["radius"] = rng.uniform(0.1, 2, count)
    if kind == "sphere":
        obj["center"] = rng.uniform(-2, 2, (count, 3))
    else:
        obj["base"] = rng.uniform(-2, 2, (count, 3))
        obj["axis"] = directions(rng, count)
        obj["length"] = rng.uniform(0.1, 2, count)
    return obj


def inside(rng: np.random.Generator, kind: str, obj: Array) -> Array:
    """Return a point in each object, or near each plane."""
    wander = directions(rng, len(obj))
    if kind == "plane":
        return np.asarray(wander - obj["dist"][:, None] * obj["normal"])
    if kind == "sphere":
        return np.asarray(obj["center"] + 0.9 * obj["radius"][:, None] * wander)
    height = rng.random(len(obj)) * (0.7 if kind == "cone" else 1)
    middle = obj["base"] + (obj["length"] * height)[:, None] * obj["axis"]
    return np.asarray(middle + (0.5 * obj["radius"] * (1 - height))[:, None] * wander)


def rays(core: Library, rng: np.random.Generator, aim: Array) -> Array:
    """Return rays that pass about 0.3 from the points of `aim`, |dir| from 0.01 to 100.

    A third start near there; half look at all that lies ahead, the others at a part of it.
    """
    count = len(aim)
    r = core.zeros("ray", count)
    away = np.where(rng.random(count) < 0.33, 0.2, 6) * rng.random(count)
    r["orig"] = aim + directions(rng, count) * away[:, None]
    length = 10 ** rng.uniform(-2, 2, (count, 1))
    r["dir"] = unit(aim + rng.normal(0, 0.2, (count, 3)) - r["orig"]) * length
    part = rng.random(count) < 0.5
    r["tmin"] = np.where(part, rng.uniform(0, 4, count), 0) / length[:, 0]
    r["tmax"] = np.where(part, r["tmin"] + rng.uniform(0, 6, count) / length[:, 0], 1e5)
    r["depth"] = rng.integers(0, 10, count)
    r["seed"] = rng.integers(1, 2**32, count)
    return r


def garbage(core: Library, rng: np.random.Generator, ctype: str, count: int) -> Array:
    """Return structs full of random bytes, to see what a function does not write."""
    raw = rng.integers(1, 120, (count, core.dtype(ctype).itemsize), dtype=np.uint8)
    return raw.view(core.dtype(ctype))[:, 0]


def same_bytes(a: Array, b: Array) -> Array:
    """Return, for each struct of two lists, whether all its bytes are the same."""
    size = a.dtype.itemsize
    raw = [np.ascontiguousarray(each).view(np.uint8).reshape(-1, size) for each in (a, b)]
    return np.asarray((raw[0] == raw[1]).all(axis=1))


def set_options(s: Session, **values: float) -> None:
    """Change some of the render options, and rebuild or drop the octree accordingly."""
    options = s.get("options").copy()
    for name, value in values.items():
        options[name] = value
    s.set("options", options)
    if "octree" in values:
        s.call("scene_changed")


def set_lights(s: Session, core: Library, positions: Array, colors: Array) -> None:
    """Replace the scene's lights."""
    found = core.zeros("light", len(positions))
    found["position"], found["col"] = positions, colors
    s.set("lights", found)
    s.set("num_lights", len(positions))


def set_scene(s: Session, obj: Array) -> None:
    """Replace the scene's objects, whose list may be empty."""
    if len(obj):
        s.set("scene", obj)
    s.set("object_count", len(obj))
    s.call("scene_changed")


def set_texture(s: Session, core: Library, texels: Array) -> None:
    """Give the scene an image of shape (height, width, 3), row 0 at the top."""
    image = core.zeros("texture")
    image["height"], image["width"] = texels.shape[:2]
    image["texels"] = s.buffer(texels.astype(np.float32))
    s.set("scene_texture", image)
