"""Making rays, materials, objects, lights and cameras, with C's own constructors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from grader.checking.shapes import Size
from grader.lab.bridge.engine import Engine, OpenSession
from grader.lab.display.values import Camera, Light, Material, Object, Ray


class Constructor:
    """The part of Core that makes values."""

    size: Size
    _engine: Engine

    def call(self, name: str, args: Sequence[Any], named: Any, size: Size | None = None) -> Any:
        """Call a C function by its name."""
        raise NotImplementedError

    def ray(
        self,
        orig: npt.ArrayLike,
        dir: npt.ArrayLike,  # noqa: A002 (C's own name)
        tmin: float = 0.0,
        tmax: float | None = None,
        depth: int = 0,
    ) -> Ray:
        """Return a ray; several where orig or dir are arrays of points, shape (..., 3)."""

        def act(stage: OpenSession) -> Ray:
            orig_array, dir_array = np.asarray(orig, np.float32), np.asarray(dir, np.float32)
            shape = np.broadcast_shapes(orig_array.shape, dir_array.shape)[:-1]
            data = np.array(stage.core.zeros("ray", shape))
            data["orig"], data["dir"], data["seed"] = orig_array, dir_array, 1
            data["tmin"], data["depth"] = tmin, depth
            data["tmax"] = stage.core.constants["RAY_TMAX"] if tmax is None else tmax
            return Ray(data)

        return self._engine.run(self.size, "ray_init", act)

    def material(
        self,
        kd: npt.ArrayLike = (0.5, 0.5, 0.5),
        ks: npt.ArrayLike = (0.0, 0.0, 0.0),
        shininess: float = 20.0,
        **fields: Any,
    ) -> Material:
        """Return a material; `fields` are further ones, such as kr or refraction_index."""
        made = self.call("init_material", (kd, ks, shininess), {})
        data = np.array(made.data)
        for name, value in fields.items():
            data[name] = value
        return Material(data)

    def sphere(self, center: npt.ArrayLike, radius: float, **material: Any) -> Object:
        """Return a sphere; `material` as in core.material, or mat=one that is made."""
        x, y, z = np.asarray(center, np.float32)
        return self._object("init_sphere", x, y, z, radius, material=material)

    def plane(self, normal: npt.ArrayLike, dist: float, **material: Any) -> Object:
        """Return the plane of the points p with p.normal + dist = 0."""
        x, y, z = np.asarray(normal, np.float32)
        return self._object("init_plane", x, y, z, dist, material=material)

    def cylinder(
        self,
        base: npt.ArrayLike,
        axis: npt.ArrayLike,
        length: float,
        radius: float,
        **material: Any,
    ) -> Object:
        """Return a cylinder that goes from its base as far as `length` along its axis."""
        return self._object("init_cylinder", base, axis, length, radius, material=material)

    def cone(
        self,
        base: npt.ArrayLike,
        axis: npt.ArrayLike,
        length: float,
        radius: float,
        **material: Any,
    ) -> Object:
        """Return a cone: its disc at the base, its apex at `length` along the axis."""
        return self._object("init_cone", base, axis, length, radius, material=material)

    def light(self, position: npt.ArrayLike, col: npt.ArrayLike = (1.0, 1.0, 1.0)) -> Light:
        """Return a point of light."""

        def act(stage: OpenSession) -> Light:
            data = np.array(stage.core.zeros("light"))
            data["position"], data["col"] = position, col
            return Light(data)

        return self._engine.run(self.size, "add_light", act)

    def camera(
        self,
        position: npt.ArrayLike = (2, 1, 3),
        at: npt.ArrayLike = (0, 0.3, 0),
        up: npt.ArrayLike = (0, 1, 0),
        fov: float = 60.0,
    ) -> Camera:
        """Return a camera that looks from `position` at a point; fov in degrees, along xdir."""
        aspect = self.size[0] / self.size[1]
        return cast(Camera, self.call("init_camera", (position, at, up, fov, aspect), {}))

    def _object(self, constructor: str, *args: Any, material: dict[str, Any]) -> Object:
        mat = material.pop("mat", None) or self.material(**material)
        return cast(Object, self.call(constructor, (*args, mat), {}))
