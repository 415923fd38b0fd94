"""A scene as Python sees it, and setting one up in a session."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from grader.checking.shapes import Size
from grader.course.exercises import CORE
from grader.execution.session import Session
from grader.lab.bridge.engine import OpenSession
from grader.lab.display.card import Shown, stack
from grader.lab.display.error_cards import sentence
from grader.lab.display.picture import Picture
from grader.lab.display.stopped import Stopped
from grader.lab.display.values import Camera, Light, Object

_PATTERN_IMAGE = 2
TEXTURE = "texture.ppm"


@dataclass(frozen=True, repr=False)
class Scene:
    """The objects, the lights and the camera."""

    objects: Object
    lights: Light
    camera: Camera

    def replaced(
        self,
        objects: Object | Sequence[Object] | None = None,
        lights: Light | Sequence[Light] | None = None,
        camera: Camera | None = None,
    ) -> Scene:
        """Return the scene with other objects, lights or camera."""
        return replace(
            self,
            objects=self.objects if objects is None else Object(_listed(objects, self.objects)),
            lights=self.lights if lights is None else Light(_listed(lights, self.lights)),
            camera=self.camera if camera is None else camera,
        )

    def __repr__(self) -> str:
        return self._shown().text

    def _repr_html_(self) -> str:
        """Return the lists, one below the other."""
        return self._shown().html

    def _shown(self) -> Shown:
        parts = (self.objects, self.lights, self.camera)
        return stack([Shown(each._repr_html_(), repr(each)) for each in parts])


def read(stage: OpenSession) -> Scene:
    """Return the scene of a session."""
    session = stage.session
    return Scene(
        Object(session.get("scene", int(session.get("object_count")))),
        Light(session.get("lights", int(session.get("num_lights")))),
        Camera(session.get("theCamera")),
    )


def write(stage: OpenSession, scene: int | Scene, folder: Path) -> None:
    """Set a scene up in a session. Raises Stopped when there is no such scene, or it is full."""
    session = stage.session
    if isinstance(scene, Scene):
        _fill(stage, scene)
    elif not session.call("setup_scene", scene).result:
        raise Stopped(sentence("lab.no_scene", number=scene))
    objects = session.get("scene", int(session.get("object_count")))
    if (objects["mat"]["pattern"] == _PATTERN_IMAGE).any():
        _lend_texture(stage, folder)


def drawn(session: Session, size: Size) -> Picture:
    """Return what raytrace() draws of a session's scene; (width, height) is that of its build."""
    session.set("output_image", np.zeros((size[0] * size[1], 3), np.float32))
    session.call("raytrace")
    return session.get("output_image").reshape(size[1], size[0], 3).view(Picture)


def _fill(stage: OpenSession, scene: Scene) -> None:
    session, constants = stage.session, stage.core.constants
    for items, most in ((scene.objects, "SCENE_SIZE"), (scene.lights, "MAX_LIGHTS")):
        if len(items) > constants[most]:
            most_items = f"{constants[most]:g}"
            raise Stopped(sentence("lab.too_many", count=len(items), most=most_items))
    target = stage.core.library.target
    camera = np.array(scene.camera.data)
    camera["aspect"] = target.width / target.height
    session.set("scene", scene.objects.data)
    session.set("object_count", len(scene.objects))
    session.set("lights", scene.lights.data)
    session.set("num_lights", len(scene.lights))
    session.set("theCamera", camera)
    session.call("scene_changed")


def _lend_texture(stage: OpenSession, folder: Path) -> None:
    """Give the session the image that ./mrt reads beside itself."""
    own = folder / TEXTURE
    with Image.open(own if own.is_file() else CORE / TEXTURE) as file:
        texels = np.asarray(file.convert("RGB"), np.float32) / 255
    texture = stage.core.zeros("texture")
    texture["height"], texture["width"] = texels.shape[:2]
    texture["texels"] = stage.session.buffer(texels)
    stage.session.set("scene_texture", texture)


def _listed(items: Any, like: Object | Light) -> Any:
    """Return the structs of one item, of a list of them, or of an array."""
    if isinstance(items, (Object, Light)):
        return items.data.reshape(-1)
    if not items:
        return np.zeros(0, like.data.dtype)
    return np.stack([each.data for each in items])
