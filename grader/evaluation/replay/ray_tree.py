"""What the replay of a pixel has seen: its rays, what each meets, and the light of each hit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from typing import Any

from grader.checking.expected_data import Array

SKY = -1  # in the place of an object's index
UNKNOWN = -2  # a hit that no object gives when it is asked alone


class Kind(Enum):
    """Where a ray comes from."""

    CAMERA = "camera"
    MIRROR = "mirror"
    REFRACTED = "refracted"


@dataclass(frozen=True)
class RayHit:
    """A point that was hit, after `t` lengths of the ray's dir; `it` is C's `intersection`."""

    t: float
    it: Any

    @property
    def position(self) -> Array:
        """The point, scene units."""
        found: Array = self.it["position"]
        return found

    @property
    def normal(self) -> Array:
        """The normal, as the function gave it."""
        found: Array = self.it["normal"]
        return found

    @property
    def material(self) -> Any:
        """The copy of the object's `material`; its kd is the pattern's where there is one."""
        return self.it["mat"]

    @property
    def is_transparent(self) -> bool:
        """Whether light goes through."""
        return bool(self.material["refraction_index"] > 0)


@dataclass(frozen=True)
class Lit:
    """A light, seen from a point that was hit."""

    index: int
    toward: Array  # unit, from the point to the light
    n_l: float
    seen: bool | None  # None: shadows are off
    adds: Array  # what shade returns

    @property
    def counts(self) -> bool:
        """Whether it lights the point."""
        return self.n_l > 0 and self.seen is not False


@dataclass(frozen=True)
class Alone:
    """What one object says of a ray when it is asked alone, by intersect_object."""

    index: int
    hit: RayHit | None
    spoilt: bool  # whether a miss has changed the ray


@dataclass(frozen=True)
class Bounce:
    """The light that comes from one more ray."""

    kind: Kind
    ray: Any  # C's `ray`: what reflected_ray or refracted_ray made
    k: Array  # what its colour is multiplied by
    color: Array  # what mirror_color or glass_color returns
    seen: Array  # what trace_ray returns for that ray


@dataclass(frozen=True)
class Node:
    """A ray and what becomes of it; colours are arrays (3,), as the C functions return them."""

    kind: Kind
    ray: Any  # C's `ray`
    trace: Array  # what trace_ray returns
    total: Array  # what the parts below add up to
    is_beyond: bool = False  # it has bounced more than max_depth times
    hit: RayHit | None = None
    object: int = SKY
    alone: tuple[Alone, ...] = ()
    toward_eye: Array | None = None  # v: unit, back along the ray
    lights: tuple[Lit, ...] = ()
    direct: Array | None = None  # what direct_light returns; None: shading is off
    bounce: Bounce | None = None
    child: Node | None = None  # the ray of the bounce; None: too faint to be followed

    def walk(self) -> Iterator[Node]:
        """Yield this ray and those that follow from it."""
        yield self
        if self.child is not None:
            yield from self.child.walk()
