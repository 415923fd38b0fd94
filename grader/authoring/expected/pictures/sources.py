"""Programs that draw: right ones that the limits are made from and tried with, and wrong ones."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from grader.authoring.expected.pictures.program import Order, RenderProgram
from grader.authoring.expected.pictures.readings import CORNERS, REFERENCE, Reading, program
from grader.authoring.expected.pictures.texels import texels
from grader.authoring.specimens import patches, variants
from grader.authoring.specimens.mistakes import Mistake
from grader.authoring.specimens.patches import PatchError
from grader.checking.pictures.plan import SAMPLES, ExpectedPicture
from grader.checking.shapes import Image

# How many mixtures of accepted choices limits are made from, and are tried with; and their seeds.
LEARNT, HELD_OUT = (40, 3), (100, 5)
# Of each line one or none: they change different functions.
_WRITTEN = (
    *(("sphere_direct", "sphere_half_b", "sphere_double", "sphere_long_double"),),
    *(("plane_by_a_point", "plane_early_returns"),),
    *(("camera_double", "camera_not_unit"),),
    *(("scene_backwards", "scene_by_copies"),),
    *(("schlick_powf",),),
)
_FLAGS = ("-O0", "-O1", "-O2", "-O3", "-O3 -ffp-contract=fast -mfma")


@dataclass(frozen=True)
class PictureSource:
    """A program that draws, with settings in the place of the pictures' own."""

    id: str
    program: RenderProgram
    settings: Mapping[str, Any] = field(default_factory=dict)
    seed: int = 0  # of what is drawn by lot

    def order(self, picture: ExpectedPicture) -> Order:
        """Return how a picture is asked for."""
        settings = dict(self.settings)
        if not picture.is_smooth:
            settings.pop("samples", None)
        seed = self.seed if picture.stage == "glass" else 0
        return Order(picture.scene, {**picture.options, **settings}, seed)

    def draw(self, picture: ExpectedPicture) -> Image:
        """Draw a picture. Raises RenderError."""
        (drawn,) = self.program.pictures([self.order(picture)], texels())
        return drawn


def right_programs() -> list[PictureSource]:
    """Return what the limits are made from."""
    found = [_by_reading(each) for each in _other_builds()] + mixtures(*LEARNT)
    for each in variants.load():
        if not each.apart:  # it draws another stage
            found.append(by_files(each.id, each.files(), each.flags, each.compiler))
    return found


def _other_builds() -> Iterator[Reading]:
    yield REFERENCE
    for flags in ("-O0", "-O1", "-O3", "-Os", "-O3 -ffp-contract=fast -mfma", "-O3 -march=native"):
        yield Reading(f"gcc {flags}", flags=tuple(flags.split()))
    yield Reading("clang -O2", compiler="clang")
    yield Reading("clang -O0", compiler="clang", flags=("-O0",))
    yield Reading("epsilon 1e-5", settings={"epsilon": 1e-5})
    yield Reading("epsilon 5e-4", settings={"epsilon": 5e-4})
    yield Reading("depth 9", settings={"max_depth": 9})  # depth >= max_depth is black
    yield Reading("normal, 1e-4", ("offset_normal",))
    yield Reading("samples 5", settings={"samples": 5})


def mixtures(count: int, seed: int) -> list[PictureSource]:
    """Return right programs that mix accepted choices, drawn by lot."""
    lot = np.random.default_rng(seed)
    return [_mixture(lot, f"mixture {seed}.{k}") for k in range(count)]


def _mixture(lot: np.random.Generator, name: str) -> PictureSource:
    """Draw a mixture: how it is written and built, sampling, epsilon, offset, lobe, rays' ends."""
    names = []
    flags = str(lot.choice(_FLAGS)).split()
    if lot.random() < 0.4:
        names.append("offset_normal")
    if lot.random() < 0.4:
        names.append("lobe_n_v")
    pattern = lot.choice(["", "corner", "end_points", "random", "random", "unclamped"])
    if pattern:
        names.append(f"samples_{pattern}")
    if pattern == "random":
        flags.append(f"-DDRAW={lot.integers(100, 2**31)}")
    if pattern == "corner":
        flags += CORNERS[str(lot.choice(list(CORNERS)))]
    if lot.random() < 0.3:
        flags.append(f"-DRAY_TMAX={lot.choice(['1e4f', '1e6f', '1e30f'])}")
    # In the middle of their squares, 2x2 samples do too; elsewhere they are as many as asked for.
    centred = pattern in ("", "unclamped")
    samples = int(lot.integers(2, 5)) if centred else SAMPLES
    settings = {"epsilon": float(10 ** lot.uniform(-4.5, -3)), "samples": samples}
    names += [str(lot.choice(each)) for each in _WRITTEN if lot.random() < 0.4]
    compiler = "clang" if "-mfma" not in flags and lot.random() < 0.2 else ""
    double = bool(lot.random() < 0.3)
    return _by_reading(Reading(name, tuple(names), tuple(flags), double, settings, compiler))


def _by_reading(reading: Reading) -> PictureSource:
    return PictureSource(
        reading.id, program(reading), reading.settings, seed=1000 + len(reading.id)
    )


def by_files(
    name: str, files: Mapping[str, str], flags: Sequence[str] = (), compiler: str = ""
) -> PictureSource:
    """Return what draws with the student's files of a program."""
    return PictureSource(name, RenderProgram(files, flags, compiler))


def by_mistake(mistake: Mistake) -> PictureSource:
    """Return what draws with a known mistake."""
    return by_files(mistake.id, mistake.files())


def by_change(name: str, before: str, after: str) -> PictureSource:
    """Return the reference with a change of its raytracer.c, where it stands once."""
    files = patches.reference()
    if files["raytracer.c"].count(before) != 1:
        raise PatchError(f"{name}: {before!r} does not stand once in raytracer.c; change it here")
    return by_files(name, {**files, "raytracer.c": files["raytracer.c"].replace(before, after)})
