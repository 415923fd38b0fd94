"""What became of the checks and of the exercises: the report and its parts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from grader.build.records import BuildResult
from grader.checking.records import Evidence
from grader.course.message import FaultError, Message
from grader.intake.records import Submission

_SAID = ("message", "places", "pixel")  # the single messages of Words


class PytestError(FaultError):
    """pytest itself failed: the grader's fault."""


class Outcome(str, Enum):
    """What became of one check."""

    PASSED = "passed"
    FAILED = "failed"
    TODO = "todo"  # not started: the exercise's marker was met and the answer is not right
    CRASHED = "crashed"
    TIMEOUT = "timeout"
    BLOCKED = "blocked"  # cannot be judged until another exercise is done
    ERROR = "error"  # the grader's or the machine's fault: never a zero


@dataclass(frozen=True)
class Finding:
    """What running one check gave, before the rules on markers and twins."""

    check: str
    title: str
    outcome: Outcome
    message: Message | None = None
    location: str = ""
    todo: frozenset[str] = frozenset()  # exercises whose MRT_TODO was met
    output: str = ""  # the beginning of what the code printed
    seconds: float = 0.0
    evidence: Evidence = field(default_factory=Evidence)
    remarks: tuple[Message, ...] = ()  # what to know besides, also of a check that passed
    through: tuple[str, ...] = ()  # exercises in whose place the reference stood when it passed
    unseen: bool = False  # right on the inputs of the archive, and this is what others gave
    alone: bool = False  # wrong with the reference's versions of all that it needs: its own fault
    pictures: tuple[str, ...] = ()  # the expected ones that were looked at
    candidates: tuple[str, ...] = ()  # ids of known mistakes that may explain a wrong picture
    observations: Mapping[str, Any] = field(default_factory=dict)  # what was wrong, by name


@dataclass(frozen=True)
class Pixel:
    """The pixel of a wrong picture to look at: column, row, and a sentence on it."""

    picture: str  # such as "scene0.flat"
    i: int
    j: int
    told: str


@dataclass(frozen=True)
class Words:
    """What the sentences on a check are made of, whatever the language: see wording.py."""

    title: str  # of a check to which messages/ gives none
    message: Message | None = None
    level: int = 0  # of help, from a question (1) to the most direct (3); 0: nothing is asked
    notes: tuple[Message, ...] = ()
    places: Message | None = None
    pixel: Message | None = None

    def as_row(self) -> dict[str, Any]:
        """Return them as JSON has them, without what there is none of."""
        row = {
            "title": self.title,
            "level": self.level,
            "notes": [each.as_row() for each in self.notes],
            **{name: said.as_row() for name in _SAID if (said := getattr(self, name)) is not None},
        }
        return {name: value for name, value in row.items() if value}

    @staticmethod
    def of_row(row: Mapping[str, Any]) -> Words:
        """Return the words of such a row."""
        return Words(
            title=row.get("title", ""),
            level=row.get("level", 0),
            notes=tuple(map(Message.of_row, row.get("notes", ()))),
            **{name: Message.of_row(row[name]) for name in _SAID if name in row},
        )


@dataclass(frozen=True)
class CheckResult:
    """One check, judged; points in hundredths. Its sentences are in the language of the run."""

    id: str
    exercise: str
    tp: int
    function: str
    title: str
    outcome: Outcome
    points: int
    max_points: int
    waits_for: tuple[str, ...] = ()  # of one that is blocked: the exercises to look at first
    message: str = ""
    hint: str = ""
    hints: Mapping[int, str] = field(default_factory=dict)  # more direct ones, by level
    note: str = ""
    location: str = ""
    output: str = ""
    seconds: float = 0.0
    mistakes: tuple[str, ...] = ()
    reproducer: str = ""
    images: Mapping[str, bytes] = field(default_factory=dict)  # PNG by role
    places: str = ""  # where a picture is wrong
    pixel: Pixel | None = None
    words: Words = field(default_factory=lambda: Words(""))


@dataclass(frozen=True)
class ExerciseResult:
    """One exercise, the sum of its checks; points in hundredths."""

    id: str
    tp: int
    function: str
    file: str
    title: str
    bonus: bool
    outcome: Outcome
    points: int
    max_points: int


@dataclass(frozen=True)
class Report:
    """Everything that results.json says."""

    submission: Submission
    language: str
    builds: tuple[BuildResult, ...]
    checks: tuple[CheckResult, ...]
    exercises: tuple[ExerciseResult, ...]
    graded_at: float  # seconds since the epoch
    notes: tuple[Message, ...] = ()
    rejected: Mapping[str, Message] = field(default_factory=dict)  # files not judged, with why
    opened: tuple[int, ...] = ()  # TPs
    unjudged: tuple[int, ...] = ()  # TPs that have no checks yet
    isolation: str = ""
    partial: bool = False  # only some of the checks were asked for
    learnt: tuple[str, ...] = ()  # exercises that are right on the inputs of the archive alone
