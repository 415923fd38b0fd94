"""`core = Core()`: the student's C functions, called from a notebook.

    core = Core()                                   # the folder core_c, found from here upwards
    img = core.image()                              # a black picture
    core.fill_circle(img, 64, (320, 180), (1, 1, 0))
    hit = core.intersect_sphere(core.ray((0, 0, 3), (0, 0, -1)), core.sphere((0, 0, 0), 1))
    hit.hit, hit.t, hit.position, hit.normal
    core.render(scene=0, shadows=False, samples=3)

Every function of exercises.h, scene.h, ray.h and vector.h is there under its own name, and
`core.shade?` shows its contract. A saved file is built again by the next call. The code runs in a
process of its own: when it crashes, the cell says where and the next cell works.
"""

from __future__ import annotations

import difflib
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar, cast

import numpy as np
import numpy.typing as npt

from grader.build.target import COUNT
from grader.checking.shapes import Size
from grader.lab.bridge import calls
from grader.lab.bridge.constructors import Constructor
from grader.lab.bridge.contracts import contracts
from grader.lab.bridge.engine import Engine, OpenSession
from grader.lab.bridge.scene import Scene, drawn, read, write
from grader.lab.cells import compare
from grader.lab.display.error_cards import sentence
from grader.lab.display.links import core_folder
from grader.lab.display.picture import Picture, black
from grader.lab.display.stopped import Stopped
from grader.lab.display.values import Camera, Light, Object, Ray
from grader.lab.display.words import say

T = TypeVar("T")

DEFAULT_SIZE: Size = (640, 360)
SMALL_SIZE: Size = (96, 54)  # where each pixel takes a few calls
EXPECTED_SIZE: Size = (320, 180)  # of the expected pictures
# Functions that look at no scene.
_APART = ("vector_", "init_", "ray_", "pixel_seed", "reflectance", "fresnel_schlick", "shade")


class CFunction:
    """One C function, to be called with Python values; its help is its contract."""

    def __init__(self, core: Core, name: str) -> None:
        self._core = core
        self.__name__ = name
        self.__doc__ = contracts()[name]

    def __call__(self, *args: Any, size: Size | None = None, **named: Any) -> Any:
        """Call the function; arrays of values make as many calls in one message.

        `size` chooses the build, by its picture's width and height. Raises Stopped.
        """
        return self._core.call(self.__name__, args, named, size)

    def __repr__(self) -> str:
        return str(self.__doc__)


@dataclass(frozen=True)
class _Wanted:
    """A scene to be set: its number, or its content."""

    number: int = 0
    content: Scene | None = None


class Core(Constructor):
    """The C code of one folder: see the module's own text for what it is used like."""

    def __init__(
        self, path: str | os.PathLike[str] | None = None, *, engine: Engine | None = None
    ) -> None:
        self.size: Size = DEFAULT_SIZE
        self._engine = engine or Engine(core_folder(path))
        self._scene = _Wanted()
        self._options: dict[str, Any] = {}

    # ---- Calling ------------------------------------------------------------------------------

    def __getattr__(self, name: str) -> CFunction:
        if name in contracts():
            return CFunction(self, name)
        near = difflib.get_close_matches(name, contracts())
        raise AttributeError(say("no_function", name=name, near=", ".join(near) or "-"))

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *contracts()]

    def __repr__(self) -> str:
        return f"Core({str(self._engine.folder)!r})"

    def call(self, name: str, args: Sequence[Any], named: Any, size: Size | None = None) -> Any:
        """Call a C function by its name; see CFunction."""
        picture = next((each for each in args if isinstance(each, Picture)), None)
        size = size or (picture.pixels if picture is not None else self.size)

        def act(stage: OpenSession) -> Any:
            if not name.startswith(_APART) and picture is None:
                self._prepare(stage, self._options)
            call = calls.bind(stage.core.functions[name], args, named)
            return calls.perform(stage.session, stage.core, call)

        return self._engine.run(size, name, act)

    def use(self, name: str, act: Callable[[OpenSession], T]) -> T:
        """Let `act` use the session, with the scene and the options that were chosen.

        `name` is the C function that it calls, for messages. Raises Stopped.
        """

        def ready(stage: OpenSession) -> T:
            self._prepare(stage, self._options)
            return act(stage)

        return self._engine.run(self.size, name, ready)

    def constant(self, name: str) -> float:
        """Return a #define or an enum of the headers, such as "EPSILON"."""
        exact = self._engine.run(self.size, name, lambda stage: stage.core.constants[name])
        return float(f"{exact:.7g}")  # 1e-4f is no round number as a double

    # ---- Pictures -----------------------------------------------------------------------------

    def image(self, size: Size | None = None) -> Picture:
        """Return a black picture (width, height), by default core.size."""
        return black(size or self.size)

    def render(
        self, scene: int | Scene | None = None, *, size: Size | None = None, **chosen: Any
    ) -> Picture:
        """Return what raytrace() draws of a scene: its number, its content, or the one in use.

        `chosen` are fields of C's `options`: shading, shadows, reflections, fresnel, refraction,
        octree (all true unless said), samples (1), max_depth (10), epsilon (1e-4). Raises Stopped.
        """
        if scene is not None:
            self._choose(scene)
        size = size or self.size

        def act(stage: OpenSession) -> Picture:
            self._prepare(stage, {**self._options, **chosen})
            return drawn(stage.session, size)

        return self._engine.run(size, "raytrace", act)

    def figure(self, name: str) -> Picture:
        """Return a figure of the handout as the code draws it, to be compared: 320 x 180 pixels.

        "figure_4", "figure_5", "figure_6", "figure_7_left", "figure_7", "figure_8",
        "figure_8_right", or an expected picture such as "scene4.shadows". Raises Stopped.
        """
        return self.render(**compare.options(name), size=EXPECTED_SIZE)

    def tests(
        self, scene: int | Scene | None = None, *, size: Size = SMALL_SIZE, **chosen: Any
    ) -> npt.NDArray[np.int64]:
        """Return how many tests of an object each pixel's ray takes with all that follow from it.

        The arguments are those of `render`; the shape is (height, width). Raises Stopped.
        """
        if scene is not None:
            self._choose(scene)

        def act(stage: OpenSession) -> npt.NDArray[np.int64]:
            self._prepare(stage, {**self._options, **chosen})
            session, ray = stage.session, stage.core.zeros("ray")
            counts = np.zeros((size[1], size[0]), np.int64)
            before = int(session.call(COUNT).result)
            for (j, i), _ in np.ndenumerate(counts):
                seen = session.call("camera_ray", ray, i + 0.5, j + 0.5)
                session.call("trace_ray", seen.args["r"])
                after = int(session.call(COUNT).result)
                counts[j, i], before = after - before, after
            return counts

        return self._engine.run(size, "trace_ray", act, counted=True)

    def camera_rays(self, size: Size | None = None) -> Ray:
        """Return the rays through the middle of every pixel, shape (height, width)."""
        width, height = size = size or self.size
        x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
        return cast(Ray, self.call("camera_ray", (x, y), {}, size))

    # ---- The scene ----------------------------------------------------------------------------

    def options(self, **chosen: Any) -> None:
        """Choose fields of `options` for the calls that follow; without any, C's own values."""
        self._options = chosen

    def scene(self, number: int | None = None) -> Scene:
        """Set a scene up, if a number is given, and return the one in use."""
        if number is not None:
            self._choose(number)

        def act(stage: OpenSession) -> Scene:
            self._prepare(stage, self._options)
            return read(stage)

        return self._engine.run(self.size, "setup_scene", act)

    def set_scene(
        self,
        objects: Object | Sequence[Object] | None = None,
        lights: Light | Sequence[Light] | None = None,
        camera: Camera | None = None,
    ) -> Scene:
        """Use a scene of your own; what is not given stays as it is. Returns the scene."""
        self._choose(self.scene().replaced(objects, lights, camera))
        return self.scene()

    # ---- The rest -----------------------------------------------------------------------------

    @property
    def seconds(self) -> float | None:
        """How long one call may take, in seconds; None: by the picture's size."""
        return self._engine.seconds

    @seconds.setter
    def seconds(self, seconds: float | None) -> None:
        self._engine.seconds = seconds

    @property
    def engine(self) -> Engine:
        """What builds and runs; for the other tools of this package."""
        return self._engine

    def close(self) -> None:
        """End the processes; the next call starts new ones."""
        self._engine.close()

    def _choose(self, scene: int | Scene) -> None:
        self._scene = _Wanted(scene) if isinstance(scene, int) else _Wanted(content=scene)

    def _prepare(self, stage: OpenSession, chosen: dict[str, Any]) -> None:
        """Bring the options and the scene of a session up to what is wanted here."""
        if stage.options != chosen:
            self._set_options(stage, chosen)
        if stage.placed is not self._scene:
            wanted, self._scene = self._scene, _Wanted()  # kept only if it can be set
            write(stage, wanted.content or wanted.number, self._engine.folder)
            self._scene = stage.placed = wanted

    def _set_options(self, stage: OpenSession, chosen: dict[str, Any]) -> None:
        if stage.defaults is None:
            stage.defaults = stage.session.get("options")
        options = np.array(stage.defaults)
        for name, value in chosen.items():
            if name not in stage.defaults.dtype.names:
                known = ", ".join(stage.defaults.dtype.names)
                raise Stopped(sentence("lab.no_option_named", name=name, known=known))
            options[name] = value
        stage.session.set("options", options)
        if stage.options.get("octree") != chosen.get("octree"):
            stage.placed = None  # the tree is made when the scene is set
        stage.options = dict(chosen)
