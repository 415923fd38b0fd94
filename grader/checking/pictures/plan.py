"""Which pictures are expected: scenes, stages of the ray tracer, and how they follow each other.

A stage is the finished program with some of its options off. Each stage of a scene has a picture,
named like "scene4.shadows". A program that ignores options draws the picture of another stage of
the same scene: one with more features.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

SWITCHES = ("shading", "shadows", "reflections", "fresnel")
# What is on, by stage; "smooth" takes 3x3 samples besides. The first six are the workbook's, each
# with what the one before lacks; the others are drawn by a program that ignores an option.
STAGES: Mapping[str, frozenset[str]] = {
    "flat": frozenset(),
    "blinn_phong": frozenset(SWITCHES[:1]),
    "shadows": frozenset(SWITCHES[:2]),
    "mirror": frozenset(SWITCHES[:3]),
    "fresnel": frozenset(SWITCHES),
    "smooth": frozenset({*SWITCHES, "samples"}),
    "blinn_phong_fresnel": frozenset({"shading", "fresnel"}),
    "shadows_fresnel": frozenset({"shading", "shadows", "fresnel"}),
    "mirror_unshadowed": frozenset({"shading", "reflections"}),
    "fresnel_unshadowed": frozenset({"shading", "reflections", "fresnel"}),
    # ks in the specular lobe, as before TP5: the handout makes Fresnel there optional.
    "fresnel_plain_lobe": frozenset(SWITCHES),
    "smooth_plain_lobe": frozenset({*SWITCHES, "samples"}),
    # Of transparent objects one ray of two, drawn by lot: known by its means alone.
    "glass": frozenset({*SWITCHES, "refraction"}),
}
COURSE = ("flat", "blinn_phong", "shadows", "mirror", "fresnel", "smooth")
_SHORT = ("flat", "blinn_phong", "shadows", "mirror", "fresnel", "fresnel_plain_lobe")
_ALL = tuple(name for name in STAGES if name != "glass")
SCENES: Mapping[int, tuple[str, ...]] = {
    0: _ALL,
    1: (*_SHORT, "smooth"),
    2: (*_SHORT, "shadows_fresnel"),
    3: ("flat", "blinn_phong", "shadows", "fresnel"),
    4: _ALL,
    5: (*_SHORT, "shadows_fresnel"),
    6: (*_SHORT, "blinn_phong_fresnel", "mirror_unshadowed", "fresnel_unshadowed"),
    7: ("glass",),
}
OCTREE = frozenset({3})  # scenes drawn with the octree, which the others must not depend on
PATTERNED = frozenset({6, 7})  # scenes with checkerboards or a texture
SAMPLES = 3  # per side of a pixel

# What the objects of a scene are called, by index: keys of [thing] in messages/.
_BALLS = ("sphere_grey", "sphere_red", "sphere_green", "sphere_blue", "floor")
_MIRRORS = ("sphere_grey", "sphere_blue", "sphere_green", "sphere_red", "floor")
THINGS: Mapping[int, tuple[str, ...]] = {
    0: _BALLS,
    1: _MIRRORS,
    2: ("sphere_white", *_MIRRORS[1:], "cylinder_left", "cylinder_up", "cylinder_front"),
    3: ("spheres",),
    4: (*_BALLS, "wall_red", "wall_green"),
    5: (
        *("cylinder_orange", "cone_red", "cone_blue", "cylinder_green"),
        *("cone_violet", "cone_yellow", "floor"),
    ),
    6: ("globe", "sphere_checkered", "cylinder_checkered", "floor"),
    7: (
        *("sphere_glass", "sphere_water", "sphere_red", "sphere_white"),
        *("sphere_green", "sphere_blue", "sphere_yellow", "floor"),
    ),
}

TRANSPARENT = frozenset({"sphere_glass", "sphere_water"})


@dataclass(frozen=True)
class ExpectedPicture:
    """One expected picture."""

    scene: int
    stage: str

    @classmethod
    def parse(cls, name: str) -> ExpectedPicture:
        """Return the picture of a name such as "scene4.shadows". Raises ValueError, KeyError."""
        scene, _, stage = name.partition(".")
        number = int(scene.removeprefix("scene"))
        if stage not in SCENES[number]:
            raise KeyError(name)
        return cls(number, stage)

    @property
    def name(self) -> str:
        """As its files are called."""
        return f"scene{self.scene}.{self.stage}"

    @property
    def options(self) -> dict[str, int]:
        """The fields of render_options that are not as they are at the start."""
        on = STAGES[self.stage]
        settings = {name: int(name in on) for name in (*SWITCHES, "refraction")}
        settings["octree"] = int(self.scene in OCTREE)
        settings["samples"] = SAMPLES if "samples" in on else 1
        return settings

    @property
    def is_smooth(self) -> bool:
        """Whether it takes several samples a pixel."""
        return "samples" in STAGES[self.stage]

    @property
    def plain_lobe(self) -> ExpectedPicture | None:
        """The same stage with ks in the specular lobe, if that is another picture."""
        name = f"{self.stage}_plain_lobe"
        return ExpectedPicture(self.scene, name) if name in SCENES[self.scene] else None

    @property
    def later(self) -> tuple[ExpectedPicture, ...]:
        """What a program that ignores options may draw instead: all that this has, and more."""
        mine = STAGES[self.stage]
        names = [name for name in SCENES[self.scene] if mine < STAGES[name]]
        return tuple(ExpectedPicture(self.scene, name) for name in names)

    @property
    def earlier(self) -> tuple[ExpectedPicture, ...]:
        """The pictures of the workbook's stages before, the nearest first."""
        mine = STAGES[self.stage]
        names = [each for each in reversed(COURSE) if each in SCENES[self.scene]]
        return tuple(ExpectedPicture(self.scene, name) for name in names if STAGES[name] < mine)


# Those that checks look at; the others are accepted in their place, or tell what is wrong.
JUDGED = (
    *(ExpectedPicture(scene, "flat") for scene in (0, 1, 2, 4, 5)),
    *(ExpectedPicture(scene, "blinn_phong") for scene in (0, 4, 6)),
    *(ExpectedPicture(scene, "shadows") for scene in (0, 2, 3, 4, 5)),
    *(ExpectedPicture(scene, "mirror") for scene in (0, 4)),
    *(ExpectedPicture(scene, "fresnel") for scene in (0, 1, 4)),
    *(ExpectedPicture(scene, "smooth") for scene in (0, 4)),
    ExpectedPicture(7, "glass"),
)


def everything() -> tuple[ExpectedPicture, ...]:
    """Return every expected picture."""
    return tuple(
        ExpectedPicture(scene, stage) for scene, names in SCENES.items() for stage in names
    )


def thing(scene: int, index: int) -> str:
    """Return what an object is called; of a scene with one name only, all are called so."""
    names = THINGS[scene]
    return names[index] if len(names) > 1 else names[0]
