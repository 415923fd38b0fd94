"""A pixel replayed: the student's functions, called one by one along its ray."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast

import numpy as np

from grader.lab.core import Core
from grader.lab.inspector.nodes import SKY, UNKNOWN, Alone, Bounce, Kind, Lit, Node
from grader.lab.picture import Picture
from grader.lab.scene import Scene
from grader.lab.values import SHAPES, Hit, Object, Ray
from grader.lab.vectors import Array
from grader.shapes import Size

SECONDS = 3.0  # of one call: someone waits for the answer
FAINT = 1 / 255  # a ray that adds less is not followed
MOST_BOUNCES = 6  # that are followed
FEW = 1100  # objects that are all asked; of more, those near the ray
NEAR = 1.2  # radii around a ray
_BEFORE = 1e-3  # share of a distance: just before it
_SPHERE = 1


class Probe:
    """A scene and its options, and the code that is looked at."""

    def __init__(
        self, folder: Path, scene: int | Scene, size: Size, chosen: Mapping[str, Any]
    ) -> None:
        """Set the scene up. Raises Stopped."""
        self.core = Core(folder)
        self.core.size, self.core.seconds = size, SECONDS
        self.size = size
        self.chosen = dict(chosen)
        self.core.options(**self.chosen)
        self.number = scene if isinstance(scene, int) else None
        if isinstance(scene, int):
            self.scene = self.core.scene(scene)
        else:
            self.scene = self.core.set_scene(scene.objects, scene.lights, scene.camera)

    def call(self, name: str, *args: Any) -> Any:
        """Call a C function. Raises Stopped."""
        return self.core.call(name, args, {})

    def picture(self) -> Picture:
        """Return what raytrace draws. Raises Stopped."""
        return self.core.render(**self.chosen)

    def on(self, option: str) -> bool:
        """Return whether a switch of `options` is on; they all are at the start."""
        return bool(self.chosen.get(option, True))

    @property
    def samples(self) -> int:
        """Samples per side of a pixel."""
        return int(self.chosen.get("samples", 1))

    @contextmanager
    def instead(self, **changed: Any) -> Iterator[None]:
        """Change options while the block runs."""
        self._apply({**self.chosen, **changed})
        try:
            yield
        finally:
            self._apply(self.chosen)

    def _apply(self, chosen: Mapping[str, Any]) -> None:
        self.core.options(**chosen)
        self.call("sky_color")  # any function that looks at the scene brings the options up

    # ---- One pixel ----------------------------------------------------------------------------

    def camera_ray(self, i: int, j: int) -> Ray:
        """Return the ray through the middle of a pixel, as raytrace prepares it."""
        data = np.array(self.call("camera_ray", i + 0.5, j + 0.5).data)
        data["seed"] = self.call("pixel_seed", i, j, 0)
        return Ray(data)

    def replay(self, i: int, j: int) -> Node:
        """Return the whole life of the ray of a pixel: column i, row j. Raises Stopped."""
        return self.follow(self.camera_ray(i, j), Kind.CAMERA, 1.0, 0)

    def follow(self, ray: Ray, kind: Kind, weight: float, bounces: int) -> Node:
        """Return what becomes of a ray whose colour counts for `weight`."""
        trace = _color(self.call("trace_ray", ray))
        if ray.depth > self.chosen.get("max_depth", 10):
            return Node(kind, ray, trace, np.zeros(3, np.float32))
        hit = cast(Hit, self.call("nearest_hit", ray))
        alone = self.alone(ray)
        if not hit:
            sky = _color(self.call("sky_color"))
            return Node(kind, ray, trace, sky, hit, SKY, alone)
        index = _object(hit, alone)
        if not self.on("shading"):
            kd = _color(hit.material.kd)
            return Node(kind, ray, trace, kd, hit, index, alone)
        v = unit(-ray.data["dir"])
        direct = _color(self.call("direct_light", hit, v))
        bounce = self._bounce(_arrived(ray, hit), hit, v)
        total = direct if bounce is None else direct + bounce.color
        child = None
        if bounce is not None:
            weight *= float(np.max(np.nan_to_num(bounce.k)))
            if weight >= FAINT and bounces < MOST_BOUNCES:
                child = self.follow(bounce.ray, bounce.kind, weight, bounces + 1)
        return Node(
            kind=kind,
            ray=ray,
            trace=trace,
            total=total,
            hit=hit,
            object=index,
            alone=alone,
            toward_eye=v,
            lights=self._lights(hit, v),
            direct=direct,
            bounce=bounce,
            child=child,
        )

    def _lights(self, hit: Hit, v: Array) -> tuple[Lit, ...]:
        lights = self.scene.lights
        if not len(lights):
            return ()
        toward = unit(lights.data["position"] - hit.data["position"])
        n_l = toward @ hit.data["normal"]
        adds = self.shade(hit, v, toward)
        shadows = self.call("in_shadow", hit, lights) if self.on("shadows") else None
        return tuple(
            Lit(k, toward[k], float(n_l[k]), None if shadows is None else not shadows[k], adds[k])
            for k in range(len(lights))
        )

    def shade(self, hit: Hit, v: Array, toward: Array, kd: Array | None = None) -> Array:
        """Return what shade returns for each light: (lights, 3); `kd` in the hit's place."""
        light, material = self.scene.lights.data["col"], np.array(hit.data["mat"])
        if kd is not None:
            material["kd"] = kd
        return np.asarray(self.call("shade", hit.data["normal"], v, toward, light, material))

    def _bounce(self, ray: Ray, hit: Hit, v: Array) -> Bounce | None:
        if self.on("refraction") and hit.material.refraction_index > 0:
            return self._through_glass(ray, hit)
        if not self.on("reflections"):
            return None
        out = cast(Ray, self.call("reflected_ray", ray, hit))
        k = _color(hit.material.ks)
        if self.on("fresnel"):
            k = _color(self.call("fresnel_schlick", hit.material.kr, hit.data["normal"], v))
        color = _color(self.call("mirror_color", ray, hit))
        return Bounce(Kind.MIRROR, out, k, color, _color(self.call("trace_ray", out)))

    def _through_glass(self, ray: Ray, hit: Hit) -> Bounce:
        """Follow the ray that glass_color has drawn: the one whose colour it returned."""
        moved = np.array(ray.data)
        color = _color(self.call("glass_color", moved, hit))  # writes the new seed there
        after = Ray(moved)
        ways: list[tuple[Kind, Ray | None]] = [
            (Kind.REFRACTED, self.call("refracted_ray", after, hit)),
            (Kind.MIRROR, self.call("reflected_ray", after, hit)),
        ]
        made = [
            Bounce(kind, out, np.ones(3, np.float32), color, _color(self.call("trace_ray", out)))
            for kind, out in ways
            if out is not None
        ]
        return min(made, key=lambda each: float(np.abs(each.seen - color).max()))

    # ---- One object ---------------------------------------------------------------------------

    def alone(self, ray: Ray) -> tuple[Alone, ...]:
        """Return what objects say of a ray when they are asked alone, those that matter."""
        which = near_ray(self.scene.objects, ray)
        if not len(which):
            return ()
        rays = np.repeat(ray.data[None], len(which))
        hits = self.call("intersect_object", rays, Object(self.scene.objects.data[which]))
        found = hits.data["hit"]
        spoilt = ~found & (rays["tmax"] != ray.data["tmax"])
        keep = np.flatnonzero(found | spoilt)
        return tuple(Alone(int(which[k]), hits[int(k)], bool(spoilt[k])) for k in keep)

    def ask(self, index: int, ray: Ray) -> Hit:
        """Return what one object says of a ray."""
        return cast(Hit, self.call("intersect_object", ray, self.scene.objects[index]))

    def careless(self, ray: Ray, t: float | None) -> list[int]:
        """Return the objects that write on a miss, or hit beyond tmax when it is lowered to `t`."""
        which = near_ray(self.scene.objects, ray)
        rays = np.repeat(ray.data[None], len(which))
        if t is not None:
            rays["tmax"] = t * (1 - _BEFORE)
        before = rays.copy()
        its = self.core.engine.run(
            self.size, "", lambda stage: stage.core.zeros("intersection", len(which))
        )
        objects = Object(self.scene.objects.data[which])
        found = np.asarray(self.call("intersect_object", rays, its, objects))
        wrote = ~found & ((rays["tmax"] != before["tmax"]) | its["normal"].any(axis=1))
        beyond = found if t is not None else np.zeros_like(found)
        return [int(each) for each in which[wrote | beyond]]

    def close(self) -> None:
        """End the processes."""
        self.core.close()


def unit(vectors: Array) -> Array:
    """Return vectors of shape (..., 3) made unit; NaN for those of length zero."""
    with np.errstate(divide="ignore", invalid="ignore"):
        made: Array = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return made


def near_ray(objects: Object, ray: Ray) -> Array:
    """Return the indices of the objects to be asked: of very many, those near the ray."""
    data = objects.data
    every = np.arange(len(data))
    if len(data) <= FEW:
        return every
    direction = unit(ray.data["dir"])
    to = data["center"] - ray.data["orig"]
    across = to - (to @ direction)[:, None] * direction
    far = np.linalg.norm(across, axis=1) > NEAR * data["radius"]
    kept: Array = every[~(far & (data["type"] == _SPHERE))]
    return kept


def shape_name(kind: int) -> str:
    """Return what C calls a type of object, in small letters: "sphere"."""
    return SHAPES.get(kind, ("object", ()))[0].lower()


def _object(hit: Hit, alone: tuple[Alone, ...]) -> int:
    """Return the index of the object that gives this hit when it is asked alone."""
    found = [each for each in alone if each.hit]
    if not found:
        return UNKNOWN
    best = min(found, key=lambda each: abs(each.hit.t - hit.t))
    return best.index if abs(best.hit.t - hit.t) <= 1e-4 * (1 + abs(hit.t)) else UNKNOWN


def _arrived(ray: Ray, hit: Hit) -> Ray:
    """Return a ray as the search leaves it: tmax lowered to its hit."""
    data = np.array(ray.data)
    data["tmax"] = hit.t
    return Ray(data)


def _color(value: Any) -> Array:
    return np.array(value, np.float32)
