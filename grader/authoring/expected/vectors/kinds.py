"""The four types of objects, each with simple rays and random objects."""

from __future__ import annotations

import numpy as np

from grader.authoring.expected.vectors.maker import Maker, norm1, result
from grader.authoring.expected.vectors.solids import CASES, Solid
from grader.checking.expected_data import Array, Batch

STEEP = 0.15  # cosine between a ray and a normal: below, the ray runs along the plane


def spheres(m: Maker) -> Solid:
    """Return the sphere."""
    count = 4
    unit = m.objects("SPHERE", count, center=(0, 0, 0), radius=1)
    unit["center"][2], unit["radius"][2] = (0, 0, 3), 2
    starts = [(0, 0, 5), (4, 0, 0), (0, 0, 9), (0, 0.5, 5)]
    ways = [(0, 0, -1), (-1, 0, 0), (0, 0, -1), (0, 0, -1)]
    simple = {"r": m.rays(starts, ways), "obj": unit}
    center, radius = m.uniform(-3, 3, CASES, 3), m.uniform(0.3, 2, CASES)
    drawn = m.objects("SPHERE", CASES, _marked(m), center=center, radius=radius)

    def near(objects: Array, spread: float) -> Array:
        reach = m.uniform(0, 1, len(objects), 1) * objects["radius"][:, None]
        return np.asarray(objects["center"] + spread * reach * m.unit(len(objects)), np.float32)

    return Solid(m, "intersect_sphere", simple, drawn, near)


def planes(m: Maker) -> Solid:
    """Return the plane; a ray that is not parallel misses it only when it goes away from it."""
    flat = m.objects("PLANE", 4, normal=(0, 1, 0), dist=0)
    flat["dist"][2:] = (2, -1)
    starts = [(0, 3, 0), (0, -3, 0), (0, 1, 0), (0, 0, 0)]
    ways = [(0, -1, 0), (0, 1, 0), (0, -1, 0), (0.6, 0.8, 0)]
    simple = {"r": m.rays(starts, ways), "obj": flat}
    drawn = m.objects("PLANE", CASES, _marked(m), normal=m.unit(CASES))
    drawn["dist"] = m.uniform(-3, 3, CASES)

    def near(objects: Array, spread: float) -> Array:
        along = m.uniform(-4, 4, len(objects), 3)
        height = np.einsum("ij,ij->i", along, objects["normal"]) + objects["dist"]
        # Rays that run along the plane meet it far away, or not at all: as good as grazing.
        return np.asarray(along - height[:, None] * objects["normal"], np.float32)

    return Solid(m, "intersect_plane", simple, drawn, near, _is_steep)


def _slope(batch: Batch) -> Array:
    way, normal = norm1(batch.args["r"]["dir"]), batch.args["obj"]["normal"]
    return np.asarray(np.abs(np.einsum("ij,ij->i", way, normal)))


def _is_steep(solid: Solid, batch: Batch) -> Array:
    return _slope(batch) > STEEP


def grazing(solid: Solid) -> Batch:
    """Return rays that run nearly along a plane, and meet it."""
    m, objects = solid.m, solid.objects
    side = norm1(np.cross(objects["normal"], m.unit(len(objects))))
    slope = m.uniform(0.005, STEEP, len(objects), 1)
    way = norm1(side - slope * objects["normal"])
    target = solid.near(objects, 1)
    rays = m.rays(target - way * m.uniform(1, 5, len(objects), 1), way)
    rays["dir"][::2], rays["orig"][::2] = -way[::2], (2 * target - rays["orig"])[::2]
    return solid.hits({"r": rays, "obj": objects})


def cylinders(m: Maker) -> Solid:
    """Return the cylinder."""
    return _tall(m, "CYLINDER", "intersect_cylinder")


def cones(m: Maker) -> Solid:
    """Return the cone."""
    return _tall(m, "CONE", "intersect_cone")


def _tall(m: Maker, kind: str, function: str) -> Solid:
    upright = m.objects(kind, 5, base=(0, 0, 0), axis=(0, 1, 0), length=2, radius=1)
    starts = [(0, 1, 5), (0, 5, 0), (0, -3, 0), (5, 0.5, 0), (0.25, -3, 0)]
    ways = [(0, 0, -1), (0, -1, 0), (0, 1, 0), (-1, 0, 0), (0, 1, 0)]
    simple = {"r": m.rays(starts, ways), "obj": upright}
    drawn = m.objects(
        kind,
        CASES,
        _marked(m),
        base=m.uniform(-3, 3, CASES, 3),
        axis=m.unit(CASES),
        length=m.uniform(0.8, 3, CASES),
        radius=m.uniform(0.4, 1.5, CASES),
    )

    def near(objects: Array, spread: float) -> Array:
        count = len(objects)
        along = 0.5 + spread * m.uniform(-0.5, 0.5, count, 1)
        wide = 1 - np.clip(along, 0, 1) if kind == "CONE" else np.ones((count, 1))
        side = norm1(np.cross(objects["axis"], m.unit(count)))
        out = spread * wide * m.uniform(0, 1, count, 1) * objects["radius"][:, None] * side
        up = along * objects["length"][:, None] * objects["axis"]
        return np.asarray(objects["base"] + up + out, np.float32)

    return Solid(m, function, simple, drawn, near, _is_on_the_side)


def _is_on_the_side(solid: Solid, batch: Batch) -> Array:
    """Say which calls meet nothing, or the side: not a disc."""
    answer = solid.m.ask(batch).answers[0]
    along = np.einsum("ij,ij->i", answer.out["it"]["normal"], batch.args["obj"]["axis"])
    return np.asarray(~result(solid.m.ask(batch)) | (np.abs(along) < 0.999))


def _marked(m: Maker) -> Array:
    """Return materials in which every field is worth copying."""
    made = m.materials(CASES, refraction_index=m.uniform(1.1, 2, CASES))
    made["pattern"] = np.arange(CASES) % 3
    return made
