"""Which pictures are expected: stages of the ray tracer in scenes, and how they follow each other.

A stage is the finished program with some of its options off. Each stage of a scene has a picture,
named like "scene4.shadows". A program that ignores options draws the picture of another stage of
the same scene: one with more features.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

from grader.course import exercises
from grader.course.scenes import SceneRules, load

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
SAMPLES = 3  # per side of a pixel


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
        if stage not in load()[number].stages:
            raise KeyError(name)
        return cls(number, stage)

    @property
    def rules(self) -> SceneRules:
        """What is said of its scene."""
        return load()[self.scene]

    @property
    def name(self) -> str:
        """As its files are called."""
        return f"scene{self.scene}.{self.stage}"

    @property
    def options(self) -> dict[str, int]:
        """The fields of render_options that are not as they are at the start."""
        on = STAGES[self.stage]
        settings = {name: int(name in on) for name in (*SWITCHES, "refraction")}
        settings["octree"] = int(self.rules.octree)
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
        return ExpectedPicture(self.scene, name) if name in self.rules.stages else None

    @property
    def later(self) -> tuple[ExpectedPicture, ...]:
        """What a program that ignores options may draw instead: all that this has, and more."""
        mine = STAGES[self.stage]
        names = [name for name in self.rules.stages if mine < STAGES[name]]
        return tuple(ExpectedPicture(self.scene, name) for name in names)

    @property
    def earlier(self) -> tuple[ExpectedPicture, ...]:
        """The pictures of the workbook's stages before, the nearest first."""
        mine = STAGES[self.stage]
        names = [each for each in reversed(COURSE) if each in self.rules.stages]
        return tuple(ExpectedPicture(self.scene, name) for name in names if STAGES[name] < mine)


def everything() -> tuple[ExpectedPicture, ...]:
    """Return every expected picture."""
    return tuple(
        ExpectedPicture(scene, stage) for scene, rules in load().items() for stage in rules.stages
    )


@cache
def judged() -> tuple[ExpectedPicture, ...]:
    """Return those that checks look at, by their stages.

    The others are accepted in their place, or tell what is wrong.
    """
    lines = (each.line for each in exercises.load().checks().values())
    asked = {each.picture for each in lines if each}
    order = [*STAGES]
    own = [each for each in everything() if each.name in asked]
    return tuple(sorted(own, key=lambda each: order.index(each.stage)))
