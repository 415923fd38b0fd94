"""The accepted readings of the handout, whose renders span the envelopes.

A reading is the reference with a patch of readings/, with flags, or with other settings.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

from grader.authoring.expected.pictures.program import Order, RenderProgram
from grader.authoring.specimens import patches
from grader.authoring.specimens.variants import FOLDER as VARIANTS
from grader.checking.expected_data import Array
from grader.checking.pictures.plan import STAGES, ExpectedPicture
from grader.checking.shapes import Image
from grader.course import exercises

FOLDER = exercises.ROOT / "reference" / "readings"
SEEDS = range(1, 9)
COARSE, FINE = 1e-3, 1e-5  # epsilons that students choose; scene units


@dataclass(frozen=True)
class Reading:
    """One way to read the handout: the reference, patched, and how it is built and asked.

    A patch is one of readings/, or a variant's.
    """

    id: str
    patches: tuple[str, ...] = ()
    flags: tuple[str, ...] = ()
    double: bool = False
    settings: Mapping[str, Any] = field(default_factory=dict)
    compiler: str = ""
    seeds: Sequence[int] = SEEDS  # of what is drawn by lot; 0: those that its own raytrace gives

    def draw(self, picture: ExpectedPicture, texels: Array, seed: int = 0) -> Image:
        """Draw a picture so."""
        order = Order(picture.scene, {**picture.options, **self.settings}, seed)
        ours = ("plain_lobe",) if picture.stage.endswith("plain_lobe") else ()
        (drawn,) = program(replace(self, patches=(*self.patches, *ours))).pictures([order], texels)
        return drawn


REFERENCE = Reading("reference")
_ALWAYS = (
    REFERENCE,
    Reading("double", double=True),
    Reading("endless_rays", flags=("-DRAY_TMAX=1e30f",)),
)
_SECONDARY = (
    Reading("coarse_epsilon", settings={"epsilon": COARSE}),
    Reading("fine_epsilon", settings={"epsilon": FINE}),
    Reading("normal_offset", ("offset_normal",), settings={"epsilon": COARSE}),
)
LOBE = Reading("lobe_n_v", ("lobe_n_v",))
# Of its square of the pixel, the one where a sample stands.
CORNERS: Mapping[str, tuple[str, ...]] = {
    "bottom_left": ("-DRIGHT=0", "-DUP=0"),
    "bottom_right": ("-DRIGHT=1", "-DUP=0"),
    "top_left": ("-DRIGHT=0", "-DUP=1"),
    "top_right": ("-DRIGHT=1", "-DUP=1"),
}
_MOVED_SAMPLES = (
    *(
        Reading(f"samples_corner_{name}", ("samples_corner",), flags)
        for name, flags in CORNERS.items()
    ),
    Reading("samples_end_points", ("samples_end_points",)),
    *(Reading(f"samples_random_{k}", ("samples_random",), (f"-DDRAW={k}",)) for k in range(1, 17)),
)
_SAMPLES = (
    Reading("samples_2", settings={"samples": 2}),
    Reading("samples_4", settings={"samples": 4}),
    Reading("samples_unclamped", ("samples_unclamped",)),
    *_MOVED_SAMPLES,
)
# A sharper highlight, moved with its samples, differs more than either alone.
_LOBE_SAMPLES = tuple(
    replace(each, id=f"{each.id}_{LOBE.id}", patches=(*each.patches, *LOBE.patches))
    for each in _MOVED_SAMPLES
)


def readings(picture: ExpectedPicture) -> Sequence[Reading]:
    """Return the accepted readings that may show in a picture; the reference's own is first."""
    on = STAGES[picture.stage]
    found = list(_ALWAYS)
    if on & {"shadows", "reflections"}:
        found += _SECONDARY
    lobe = "fresnel" in on and not picture.stage.endswith("plain_lobe")
    if lobe:
        found.append(LOBE)
    if picture.is_smooth:
        found += _SAMPLES
        if lobe:
            found += _LOBE_SAMPLES
    if picture.stage == "glass":
        found.append(Reading("plain_lobe", ("plain_lobe",)))
        # raytrace is not told to give its rays a seed: all the pixels may draw alike.
        found.append(Reading("seed_of_ray_init", ("seed_of_ray_init",), seeds=(0,)))
    return found


def program(reading: Reading) -> RenderProgram:
    """Return the program of a reading."""
    return _program(reading.patches, reading.flags, reading.double, reading.compiler)


@cache
def _program(
    names: tuple[str, ...], flags: tuple[str, ...], double: bool, compiler: str
) -> RenderProgram:
    files = patches.reference()
    for name in names:
        path = FOLDER / f"{name}.patch"
        files = patches.patched(path if path.is_file() else VARIANTS / path.name, files)
    return RenderProgram(files, flags, compiler, double)
