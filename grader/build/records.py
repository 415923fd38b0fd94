"""What is built, and what came of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum

from grader.course.message import FaultError


class BindError(FaultError):
    """The given headers cannot be preprocessed or read: not the submission's fault."""


class BuildStatus(str, Enum):
    """Whether a submission became a library."""

    BUILT = "built"
    REJECTED = "rejected"  # nothing could be made of the student's files


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
