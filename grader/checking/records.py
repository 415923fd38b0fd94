"""What a failed check shows beside its sentence."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from grader.course.message import Message


@dataclass(frozen=True)
class Spot:
    """A pixel of a wrong picture, such as "scene0.flat": column, row, and what was drawn there."""

    picture: str
    i: int
    j: int
    color: tuple[float, float, float]


@dataclass(frozen=True)
class Pinned:
    """A pixel of a wrong picture: the first value that goes wrong there, or how the code ended."""

    picture: str
    i: int
    j: int
    told: Message | None = None  # None: no value is named
    location: str = ""  # where the code was when it ended, "file:line"


@dataclass(frozen=True)
class Evidence:
    """What a failed check shows beside its sentence."""

    share: float = 0.0  # of the points, for what is right all the same
    reproducer: str = ""  # C statements that make the simplest failing call
    images: Mapping[str, bytes] = field(default_factory=dict)  # PNG: expected, got, difference
    places: Message | None = None  # where a picture is wrong
    mistakes: tuple[str, ...] = ()  # ids of the known mistakes that give the same answers
    spots: tuple[Spot, ...] = ()  # of a wrong picture, those to look at, the first one first
    pinned: Pinned | None = None
