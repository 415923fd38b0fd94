"""What passes between the stages of `make oral`: frozen records."""

from __future__ import annotations

from dataclasses import dataclass

from grader.authoring.specimens.mistakes import Mistake
from grader.checking.shapes import Image
from grader.evaluation.records import CheckResult


@dataclass(frozen=True)
class Place:
    """Lines of a submission's own file, from `line` (counted from 1) on, in a function."""

    file: str
    line: int
    function: str
    text: str

    @property
    def at(self) -> str:
        """The file and the line, as compilers write them."""
        return f"{self.file}:{self.line}"


@dataclass(frozen=True)
class Change:
    """A known mistake put into a student's own lines; `content` is the whole file after."""

    mistake: Mistake
    place: Place
    new: str  # the lines after; "" when they are gone
    content: str


@dataclass(frozen=True)
class Drawn:
    """A picture that a program drew; or the sentence that says how it ended instead."""

    picture: Image | None = None
    death: str = ""


@dataclass(frozen=True)
class Sight:
    """The same picture before and after a change. `changed` is the share of the pixels, 0 to 1."""

    call: str  # the call, or the command line, that draws it
    scene: int | None  # its number, for setup_scene; None: a call of TP1's
    before: Image
    after: Drawn
    changed: float


@dataclass(frozen=True)
class Swapped:
    """A question on a changed line: what is lost, and what is seen. Points in hundredths."""

    change: Change
    failed: tuple[CheckResult, ...]
    lost: int
    points: int  # of the exercise
    sight: Sight | None = None


@dataclass(frozen=True)
class Value:
    """One value that a call gives; `expected` is "" where it is right."""

    name: str
    got: str
    expected: str = ""


@dataclass(frozen=True)
class Traced:
    """A question on what a function gives for one call."""

    exercise: str
    place: Place
    call: str
    values: tuple[Value, ...]


Question = Swapped | Traced
