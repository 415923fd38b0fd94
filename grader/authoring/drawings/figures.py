"""Draw the handout's figures, the project's own scenes, and a contact sheet of them all.

The pictures come from the solution in reference/, called function by function: figure 1 is made of
the calls of ``./mrt 0`` to ``./mrt 3``, and each later stage of the ray tracer is the same finished
program with some of its options off. Figure 2 of the handout is a sketch, not a picture.
Run it as ``python -m grader.authoring.drawings.figures [--build DIR] [--width PIXELS]``.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image

from grader.authoring.drawings.contact_sheet import SheetPicture, contact_sheet, save, to_pixels
from grader.authoring.drawings.texture import TEXTURE
from grader.course.exercises import ROOT
from grader.course.message import UserError
from grader.course.settings import COMPLETE
from grader.course.texts import Texts, preferred
from grader.execution.session import Died, Library, Limits, MachineError, Session, open_core

Array = npt.NDArray[Any]
Floats = npt.NDArray[np.float32]
Paint = Callable[[Library, Session], Floats]

WIDTH = 1280  # as the handout's; the height is 9/16 of it
LIMITS = Limits(cpu=600, memory=1 << 30)


@dataclass(frozen=True)
class Figure:
    """One picture: the name of its file, and how it is drawn; messages/ has its caption, `drawn`.

    `paint` returns colours of shape (height * width, 3), the bottom row first, not clamped.
    """

    name: str
    paint: Paint


# ---- Figure 1: the functions of TP1 -----------------------------------------------------------


def size(core: Library) -> tuple[int, int]:
    """Return the width and the height of the pictures of this build."""
    return int(core.constants["WIDTH"]), int(core.constants["HEIGHT"])


def apply(core: Library, s: Session, calls: Sequence[tuple[Any, ...]]) -> Floats:
    """Return a black image after calls of TP1's functions: each a name, then what follows img."""
    width, height = size(core)
    image: Floats = core.zeros("color", width * height)
    for name, *arguments in calls:
        image = s.call(name, image, *arguments).args["img"]
    return image


def red(core: Library, s: Session) -> Floats:
    """./mrt 0."""
    return apply(core, s, [("fill_red",)])


def rectangle(core: Library, s: Session) -> Floats:
    """./mrt 1."""
    width, height = size(core)
    corners = (width / 4, height / 5, 0), (width / 3, height / 4, 0)
    return apply(core, s, [("fill", (0.7, 0.3, 0.1)), ("fill_rect", (0.2, 0.6, 0.7), *corners)])


GRADIENT = ("horizontal_gradient", (0, 0, 1), (1, 1, 1))


def gradient(core: Library, s: Session) -> Floats:
    """./mrt 2."""
    return apply(core, s, [GRADIENT])


def landscape(core: Library, s: Session) -> Floats:
    """./mrt 3."""
    width, height = size(core)
    sun = ("fill_circle", width / 20, (4 * width / 5, 4 * height / 5, 0), (1, 1, 0))
    grass = ("fill_rect", (0.1, 0.8, 0.4), (0, 0, 0), (width, height / 4, 0))
    return apply(core, s, [GRADIENT, sun, grass])


# ---- Figure 3: the camera's rays ---------------------------------------------------------------


def directions(core: Library, s: Session) -> Floats:
    """Colour each pixel by where its ray crosses the image plane, -1 to 1 becoming 0 to 1."""
    width, height = size(core)
    s.call("setup_scene", 0)
    camera = s.get("theCamera")
    # Half of the image plane's sides, at distance 1 from the camera.
    half_width = np.tan(np.radians(camera["fov"]) / 2)
    half = {"xdir": half_width, "ydir": half_width / camera["aspect"]}
    image: Floats = np.zeros((height, width, 3), np.float32)
    x = np.arange(width, dtype=np.float32) + 0.5
    for j in range(height):
        rays = core.zeros("ray", width)
        ray = s.call_many("camera_ray", width, rays, x, np.full_like(x, j + 0.5)).args["r"]["dir"]
        depth = ray @ camera["zdir"]
        for channel, axis in enumerate(half):
            image[j, :, channel] = ray @ camera[axis] / depth / half[axis] * 0.5 + 0.5
    return image.reshape(-1, 3)


# ---- The rest: scenes, drawn by the ray tracer --------------------------------------------------


def lend_texture(core: Library, s: Session) -> None:
    """Give the program the texture that ./mrt reads beside it."""
    with Image.open(TEXTURE) as file:
        texels = np.asarray(file.convert("RGB"), dtype=np.float32) / 255
    texture = core.zeros("texture")
    texture["height"], texture["width"] = texels.shape[:2]
    texture["texels"] = s.buffer(texels)
    s.set("scene_texture", texture)


def scene(core: Library, s: Session, number: int, settings: Mapping[str, float]) -> Floats:
    """Return the picture of a scene, with these options changed."""
    options = s.get("options")
    for name, value in settings.items():
        options[name] = value
    s.set("options", options)
    lend_texture(core, s)
    s.call("setup_scene", number)
    s.call("raytrace")
    return s.get("output_image")


def of_scene(number: int, **settings: float) -> Paint:
    """Return what paints a scene with some options changed, such as shadows=False or samples=3."""
    return partial(scene, number=number, settings=settings)


DIRECT = {"reflections": False, "fresnel": False}

FIGURES = (
    Figure("figure_1_mrt_0", red),
    Figure("figure_1_mrt_1", rectangle),
    Figure("figure_1_mrt_2", gradient),
    Figure("figure_1_mrt_3", landscape),
    Figure("figure_3", directions),
    Figure("figure_4", of_scene(0, shading=False)),
    Figure("figure_5", of_scene(0, shadows=False, **DIRECT)),
    Figure("figure_6_left", of_scene(0, **DIRECT)),
    Figure("figure_6_right", of_scene(0, epsilon=0, **DIRECT)),
    Figure("figure_7_left", of_scene(0, fresnel=False)),
    Figure("figure_7_right", of_scene(0)),
    Figure("figure_8_left", of_scene(0, samples=3)),
    Figure("figure_8_right", of_scene(4, samples=3)),
    Figure("figure_9", of_scene(8, samples=3)),
    Figure("scene_5", of_scene(5, samples=3)),
    Figure("scene_6", of_scene(6, samples=3)),
    Figure("scene_7", of_scene(7, samples=4)),
    Figure("scene_9", of_scene(9, samples=3)),
    Figure("scene_10", of_scene(10, samples=4)),
)


# ---- The command ---------------------------------------------------------------------------------


def draw(core: Library, figure: Figure) -> SheetPicture:
    """Draw one figure in a process of its own. Raises Died."""
    with core.session(LIMITS) as s:
        pixels = to_pixels(figure.paint(core, s), *size(core))
    captions = tuple(Texts(each).say(f"drawn.{figure.name}") for each in COMPLETE)
    return SheetPicture(captions, pixels)


def draw_all(build: Path, width: int) -> None:
    """Write every figure and the contact sheet in build/figures/, and name the files."""
    out = build / "figures"
    out.mkdir(parents=True, exist_ok=True)
    drawn = []
    with open_core(ROOT / "reference", width, width * 9 // 16, cache=build / "cache") as core:
        for figure in FIGURES:
            drawn.append(draw(core, figure))
            path = out / f"{figure.name}.png"
            save(Image.fromarray(drawn[-1].pixels), path)
            print(path)
    save(contact_sheet(drawn), out / "contact_sheet.png")
    print(out / "contact_sheet.png")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return 0, or 1 after one line on stderr."""
    parser = argparse.ArgumentParser(
        prog="python -m grader.authoring.drawings.figures", description=__doc__
    )
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--build", type=Path, default=ROOT / "build", metavar="DIR")
    parser.add_argument("--width", type=int, default=WIDTH, metavar="PIXELS")
    arguments = parser.parse_args(argv)
    if arguments.width < 32:
        parser.error("--width must be at least 32")
    try:
        draw_all(arguments.build, arguments.width)
    except UserError as error:
        print(error.sentence(Texts(preferred())), file=sys.stderr)
    except OSError as error:
        where, why = error.filename or arguments.build, error.strerror or error
        print(f"{where}: {why}; check it, or give --build DIR", file=sys.stderr)
    except (Died, MachineError) as error:
        print(f"reference/: {error}; run `make test`, which says more", file=sys.stderr)
    else:
        return 0
    return 1


if __name__ == "__main__":
    sys.exit(main())
