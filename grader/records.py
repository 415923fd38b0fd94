"""Records that pass between the stages of the grader: frozen, without any input or output."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any


class Told(Exception):
    """An error with a sentence for the person at the terminal, by its key in messages/."""

    def __init__(self, key: str, **values: object) -> None:
        super().__init__(f"{key}: {values}")
        self.key = key
        self.values = values


class BindError(Exception):
    """The given headers cannot be preprocessed or read: not the submission's fault."""


class PytestError(Exception):
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


class Cause(str, Enum):
    """How the process that ran the student's code ended before it had answered."""

    SIGNAL = "signal"
    EXIT = "exit"  # the code called exit, or closed the grader's channel
    TIMEOUT = "timeout"
    LOAD = "load"  # the library cannot be loaded: a global is missing
    MEMORY = "memory"  # none was left to go on with
    STRAY_WRITE = "stray_write"  # a write just before a table, seen after the call
    KILLED = "killed"  # by SIGKILL, which nothing of ours sent: by itself, or from outside


class BuildStatus(str, Enum):
    """Whether a submission became a library."""

    BUILT = "built"
    REJECTED = "rejected"  # nothing could be made of the student's files


@dataclass(frozen=True)
class Source:
    """A file as it was found: its name, where it is for the person, when it was last written."""

    name: str
    path: str
    modified: float  # seconds since the epoch


@dataclass(frozen=True)
class Refusal:
    """A file that was not taken; `reason` is a key of [refused] in messages/."""

    path: str
    reason: str


@dataclass(frozen=True)
class Submission:
    """The C files of a submission that are judged, by name; and what was found around them."""

    name: str
    files: Mapping[str, bytes]
    missing: tuple[str, ...]  # the student's files that are not there: the skeleton's stand in
    refused: tuple[Refusal, ...] = ()
    sources: tuple[Source, ...] = ()  # the student's files that were taken, in the course's order
    changed: tuple[str, ...] = ()  # given files that are not the original: not used
    converted: tuple[str, ...] = ()  # files that were in UTF-16
    nearby: tuple[Source, ...] = ()  # other versions of the student's files, close to the folder
    in_place: bool = False  # it is core_c itself: the originals are in the package
    authors: bytes = b""  # the content of its AUTEURS.txt


@dataclass(frozen=True)
class Target:
    """One way of building: picture size in pixels, with or without sanitizers, further flags.

    `counted`: the library counts how often the functions that intersect an object are entered.
    """

    width: int
    height: int
    sanitized: bool = False
    defines: tuple[str, ...] = ()
    counted: bool = False


@dataclass(frozen=True)
class Parameter:
    """One parameter of a C function: its name, its C type, and for a pointer what it points to."""

    name: str
    ctype: str
    pointee: str = ""  # "" for a value


@dataclass(frozen=True)
class Function:
    """A C function that the worker can call: under `symbol`, which may be a wrapper of the shim.

    `result` is "" for void. With `boxed`, the symbol's first parameter points to the result.
    Parameters listed in `by_address` are values in C that the wrapper takes by their address.
    """

    name: str
    symbol: str
    result: str
    parameters: tuple[Parameter, ...]
    boxed: bool = False
    by_address: tuple[str, ...] = ()


@dataclass(frozen=True)
class Binding:
    """What the headers declare, for one picture size; everything cffi and numpy need."""

    cdef: str
    functions: dict[str, Function]
    variables: dict[str, str]  # name to C type
    structs: dict[str, tuple[str, ...]]  # name to the names of its fields
    constants: tuple[str, ...]


@dataclass(frozen=True)
class BuildResult:
    """One build of one submission. `library` is "" unless the status is BUILT."""

    status: BuildStatus
    target: Target
    library: str = ""
    binding: Binding | None = None
    preload: str = ""  # the sanitizers' runtime, to be loaded before everything else
    log: str = ""  # the compiler's errors, with the student's own file names
    warnings: tuple[str, ...] = ()
    rejected: Mapping[str, str] = field(default_factory=dict)  # errors of the files left out
    cxx: tuple[str, ...] = ()  # files built as C++
    linker: str = ""  # what keeps the files from making a program, though they can be judged
    tables: str = ""  # a library of the headers' constants and sizes, without the submission


@dataclass(frozen=True)
class Death:
    """Why a process that ran student code is gone.

    `word` is a signal's name (SIGSEGV) or the sanitizer's word (heap-buffer-overflow);
    `case` is the number, in the batch, of the call that was running; `location` is "file:line"
    or "".
    """

    cause: Cause
    word: str = ""
    code: int = 0
    case: int = 0
    location: str = ""
    text: str = ""
    function: str = ""  # in which it was, when that is known
    seconds: float = field(default=0.0, compare=False)  # of CPU that it was allowed


@dataclass(frozen=True)
class Verdict:
    """What is wrong: the sentence of `key` in messages/, with its values."""

    key: str
    values: dict[str, object] = field(default_factory=dict)


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
    told: Verdict | None = None  # None: no value is named
    location: str = ""  # where the code was when it ended, "file:line"


@dataclass(frozen=True)
class Evidence:
    """What a failed check shows beside its sentence."""

    share: float = 0.0  # of the points, for what is right all the same
    reproducer: str = ""  # C statements that make the simplest failing call
    images: Mapping[str, bytes] = field(default_factory=dict)  # PNG: expected, got, difference
    mistakes: tuple[str, ...] = ()  # ids of the known mistakes that give the same answers
    spots: tuple[Spot, ...] = ()  # of a wrong picture, those to look at, the first one first
    pinned: Pinned | None = None


@dataclass(frozen=True)
class Finding:
    """What running one check gave, before the rules on markers and twins."""

    check: str
    title: str
    outcome: Outcome
    verdict: Verdict | None = None
    location: str = ""
    todo: frozenset[str] = frozenset()  # exercises whose MRT_TODO was met
    output: str = ""  # the beginning of what the code printed
    seconds: float = 0.0
    evidence: Evidence = Evidence()
    remarks: tuple[Verdict, ...] = ()  # what to know besides, also of a check that passed
    through: tuple[str, ...] = ()  # exercises in whose place the reference stood when it passed
    alone: bool = False  # wrong with the reference's versions of all that it needs: its own fault
    testimony: Mapping[str, Any] = field(default_factory=dict)  # what was wrong: see testimony.py


@dataclass(frozen=True)
class Pixel:
    """The pixel of a wrong picture to look at: column, row, and a sentence on it."""

    picture: str  # such as "scene0.flat"
    i: int
    j: int
    told: str


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
    message: str = ""
    hint: str = ""
    note: str = ""
    location: str = ""
    output: str = ""
    seconds: float = 0.0
    mistakes: tuple[str, ...] = ()
    reproducer: str = ""
    images: Mapping[str, bytes] = field(default_factory=dict)  # PNG by role
    pixel: Pixel | None = None


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
    notes: tuple[str, ...] = ()
    rejected: Mapping[str, str] = field(default_factory=dict)  # files not judged, with why
    opened: tuple[int, ...] = ()  # TPs
    unjudged: tuple[int, ...] = ()  # TPs that have no checks yet
    isolation: str = ""
    partial: bool = False  # only some of the checks were asked for
