"""Calling a submission's functions along the ray of a pixel."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cached_property
from typing import Any

import numpy as np

from grader.checking import expected_data
from grader.checking.expected_data import Array
from grader.checking.shapes import Size
from grader.evaluation.replay.caller import Caller, Content
from grader.evaluation.replay.ray_tree import UNKNOWN, Alone, Bounce, Kind, Lit, Node, RayHit
from grader.execution.marshalling import Reply
from grader.execution.session import Library, Session
from grader.intake.header_numbers import header_number

FAINT = 1 / 255  # a ray that adds less is not followed
MOST_BOUNCES = 6  # that are followed
FEW = 64  # objects that are all asked; of more, those near the ray
NEAR = 1.2  # radii around a ray
_SAME = 1e-4  # share of a distance within which two hits are one
_BEFORE = 1e-3  # share of a distance: just before it


class Probe:
    """A submission at work on a scene."""

    def __init__(self, caller: Caller, size: Size, number: int | None) -> None:
        """Read the scene; `number` is its own, None for one that has none. Raises as the desk."""
        self.size, self.number = size, number
        self._caller = caller

        def read(session: Session, core: Library) -> Content:
            self._no_ray, self._no_hit = core.zeros("ray"), core.zeros("intersection")
            return Content(
                objects=session.get("scene", int(session.get("object_count"))),
                lights=session.get("lights", int(session.get("num_lights"))),
                camera=session.get("theCamera"),
                options=session.get("options"),
            )

        self.content = caller.ask("setup_scene", read)

    # ---- Calls --------------------------------------------------------------------------------

    def call(self, name: str, *args: Any) -> Reply:
        """Call a function once."""
        return self._caller.ask(name, lambda session, _: session.call(name, *args))

    def many(self, name: str, count: int, *args: Any) -> Reply:
        """Call a function `count` times, in one message."""
        return self._caller.ask(name, lambda session, _: session.call_many(name, count, *args))

    def on(self, option: str) -> bool:
        """Return whether a switch of `options` is on."""
        return bool(self.content.options[option])

    @contextmanager
    def instead(self, **changed: Any) -> Iterator[None]:
        """Change options while the block runs; if that ends the session, the next has its own."""
        options = self.content.options.copy()
        for name, value in changed.items():
            options[name] = value
        self._set(options)
        yield
        self._set(self.content.options)

    def _set(self, options: Any) -> None:
        self._caller.ask("options", lambda session, _: session.set("options", options))

    def textured(self, hit: RayHit, texels: Array) -> Array:
        """Return what surface_color gives for a hit with another texture."""

        def act(session: Session, core: Library) -> Any:
            own = session.get("scene_texture")
            expected_data.lend_texture(session, core, texels)
            found = session.call("surface_color", hit.it).result
            session.set("scene_texture", own)
            return found

        return self._caller.ask("surface_color", act)

    # ---- One pixel ----------------------------------------------------------------------------

    def replay(self, i: int, j: int) -> Node:
        """Return the whole life of the ray through the middle of a pixel: column i, row j."""
        ray = self.call("camera_ray", self._no_ray, i + 0.5, j + 0.5).args["r"].copy()
        ray["seed"] = self.call("pixel_seed", i, j, 0).result
        return self.follow(ray, Kind.CAMERA, self.trace(ray), 1.0, 0)

    def follow(self, ray: Any, kind: Kind, trace: Array, weight: float, bounces: int) -> Node:
        """Return what becomes of a ray of the colour `trace`, which counts for `weight`."""
        if ray["depth"] > self.content.options["max_depth"]:
            return Node(kind, ray, trace, np.zeros(3, np.float32), is_beyond=True)
        hit, alone = self.nearest(ray), self.alone(ray)
        if hit is None:
            sky = self.call("sky_color").result
            return Node(kind, ray, trace, sky, alone=alone)
        index = _object(hit, alone)
        if not self.on("shading"):
            color = hit.material["kd"]
            return Node(kind, ray, trace, color, hit=hit, object=index, alone=alone)
        v = unit(-ray["dir"])
        direct = self.call("direct_light", hit.it, v).result
        bounce = self._bounce(_arrived(ray, hit), hit, v)
        child = None
        if bounce is not None:
            weight *= float(np.max(np.nan_to_num(bounce.k)))
            if weight >= FAINT and bounces < MOST_BOUNCES:
                child = self.follow(bounce.ray, bounce.kind, bounce.seen, weight, bounces + 1)
        return Node(
            kind=kind,
            ray=ray,
            trace=trace,
            total=direct if bounce is None else direct + bounce.color,
            hit=hit,
            object=index,
            alone=alone,
            toward_eye=v,
            lights=self._lights(hit, v),
            direct=direct,
            bounce=bounce,
            child=child,
        )

    def trace(self, ray: Any) -> Array:
        """Return what trace_ray returns."""
        found: Array = self.call("trace_ray", ray).result
        return found

    def nearest(self, ray: Any) -> RayHit | None:
        """Return what nearest_hit finds."""
        return _hit(self.call("nearest_hit", ray, self._no_hit))

    def total(self, ray: Any, hit: RayHit) -> Array:
        """Return what the functions add up to at a hit, with every feature."""
        after = _arrived(ray, hit)
        direct = self.call("direct_light", hit.it, unit(-ray["dir"])).result
        name = "glass_color" if hit.is_transparent else "mirror_color"
        added: Array = direct + self.call(name, after, hit.it).result
        return added

    def _lights(self, hit: RayHit, v: Array) -> tuple[Lit, ...]:
        lights = self.content.lights
        if not len(lights):
            return ()
        toward = unit(lights["position"] - hit.position)
        n_l, adds = toward @ hit.normal, self.shade(hit, v, toward)
        hidden = None
        if self.on("shadows"):
            hidden = self.many("in_shadow", len(lights), hit.it, lights).result
        return tuple(
            Lit(k, toward[k], float(n_l[k]), None if hidden is None else not hidden[k], adds[k])
            for k in range(len(lights))
        )

    def shade(self, hit: RayHit, v: Array, toward: Array, kd: Array | None = None) -> Array:
        """Return what shade returns for each light: (lights, 3); `kd` in the hit's place."""
        light, material = self.content.lights["col"], hit.material.copy()
        if kd is not None:
            material["kd"] = kd
        count = len(light)
        found: Array = self.many("shade", count, hit.normal, v, toward, light, material).result
        return found

    def _bounce(self, ray: Any, hit: RayHit, v: Array) -> Bounce | None:
        if self.on("refraction") and hit.is_transparent:
            return self._through_glass(ray, hit)
        if not self.on("reflections"):
            return None
        out = self.reflected(ray, hit)
        k = hit.material["ks"]
        if self.on("fresnel"):
            k = self.call("fresnel_schlick", hit.material["kr"], hit.normal, v).result
        color = self.call("mirror_color", ray, hit.it).result
        return Bounce(Kind.MIRROR, out, k, color, self.trace(out))

    def reflected(self, ray: Any, hit: RayHit) -> Any:
        """Return the ray that reflected_ray makes."""
        return self.call("reflected_ray", self._no_ray, ray, hit.it).args["out"]

    def refracted(self, ray: Any, hit: RayHit) -> Any | None:
        """Return the ray that refracted_ray makes; None when it says that there is none."""
        reply = self.call("refracted_ray", self._no_ray, ray, hit.it)
        return reply.args["out"] if reply.result else None

    def _through_glass(self, ray: Any, hit: RayHit) -> Bounce:
        """Follow the ray that glass_color has drawn: the one whose colour it returned."""
        reply = self.call("glass_color", ray, hit.it)
        after, color = reply.args["in"], reply.result  # the seed has moved on
        ways = (
            (Kind.REFRACTED, self.refracted(after, hit)),
            (Kind.MIRROR, self.reflected(after, hit)),
        )
        made = [
            Bounce(kind, out, np.ones(3, np.float32), color, self.trace(out))
            for kind, out in ways
            if out is not None
        ]
        return min(made, key=lambda each: float(np.abs(each.seen - color).max()))

    # ---- One object ---------------------------------------------------------------------------

    def alone(self, ray: Any) -> tuple[Alone, ...]:
        """Return what objects say of a ray when they are asked alone, those that matter."""
        return self.alone_each([ray])[0]

    def alone_each(self, rays: Sequence[Any]) -> list[tuple[Alone, ...]]:
        """Return what objects say of rays that lie close to one another, in one message."""
        which, before, found, after, its = self._ask_each(rays)
        spoilt = ~found & (after["tmax"] != before["tmax"])

        def said(k: int, n: int) -> Alone:
            hit = RayHit(float(after["tmax"][k, n]), its[k, n]) if found[k, n] else None
            return Alone(int(which[n]), hit, bool(spoilt[k, n]))

        return [
            tuple(said(k, int(n)) for n in np.flatnonzero(found[k] | spoilt[k]))
            for k in range(len(rays))
        ]

    def ask(self, index: int, ray: Any) -> RayHit | None:
        """Return what one object says of a ray."""
        return _hit(self.call("intersect_object", ray, self._no_hit, self.content.objects[index]))

    def careless(self, ray: Any, t: float | None) -> list[int]:
        """Return the objects that write on a miss, or hit beyond tmax when it is lowered to `t`."""
        short = ray.copy()
        if t is not None:
            short["tmax"] = t * (1 - _BEFORE)
        which, before, found, after, its = self._ask_each([short])
        wrote = ~found & ((after["tmax"] != before["tmax"]) | its["normal"].any(axis=-1))
        beyond = found if t is not None else np.zeros_like(found)
        return [int(each) for each in which[(wrote | beyond)[0]]]

    def _ask_each(self, rays: Sequence[Any]) -> tuple[Array, Array, Array, Array, Array]:
        """Ask the objects near the first ray: their indices (n,), and tables of (rays, n).

        The tables are the rays before, whether there is a hit, the rays and the hits after.
        """
        which = self._near(rays[0])
        shape = len(rays), len(which)
        before = np.repeat(np.stack([np.asarray(each) for each in rays]), len(which))
        if not before.size:
            none = np.zeros(shape, self._no_hit.dtype)
            return which, before.reshape(shape), np.zeros(shape, bool), before.reshape(shape), none
        objects = np.tile(self.content.objects[which], len(rays))
        reply = self.many("intersect_object", before.size, before, self._no_hit, objects)
        after, its = reply.args["r"].reshape(shape), reply.args["it"].reshape(shape)
        return which, before.reshape(shape), reply.result.reshape(shape), after, its

    def _near(self, ray: Any) -> Array:
        """Return the indices of the objects to be asked: of very many, those near the ray."""
        every = np.arange(len(self.content.objects))
        if len(every) <= FEW:
            return every
        centers, radii, others = self._spheres
        to, direction = centers - ray["orig"], unit(ray["dir"])
        along = to @ direction
        aside = np.einsum("ij,ij->i", to, to) - along * along
        kept: Array = every[others | ~(aside > (NEAR * radii) ** 2)]
        return kept

    @cached_property
    def _spheres(self) -> tuple[Array, Array, Array]:
        """Centres and radii side by side in memory, and which objects are no spheres."""
        objects = self.content.objects
        centers, radii = (np.ascontiguousarray(objects[name]) for name in ("center", "radius"))
        return centers, radii, objects["type"] != header_number("SPHERE")


def unit(vectors: Array) -> Array:
    """Return vectors of shape (..., 3) made unit; NaN for those of length zero."""
    with np.errstate(divide="ignore", invalid="ignore"):
        made: Array = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return made


def _hit(reply: Reply) -> RayHit | None:
    return RayHit(float(reply.args["r"]["tmax"]), reply.args["it"]) if reply.result else None


def _object(hit: RayHit, alone: tuple[Alone, ...]) -> int:
    """Return the index of the object that gives this hit when it is asked alone."""
    found = [(abs(each.hit.t - hit.t), each.index) for each in alone if each.hit is not None]
    away, index = min(found, default=(np.inf, UNKNOWN))
    return index if away <= _SAME * (1 + abs(hit.t)) else UNKNOWN


def _arrived(ray: Any, hit: RayHit) -> Any:
    """Return a ray as the search leaves it: tmax lowered to its hit."""
    arrived = ray.copy()
    arrived["tmax"] = hit.t
    return arrived
