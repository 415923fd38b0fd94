"""Calling a submission's functions, which run in another process, with numpy arrays.

    from grader.execution.session import open_core

    with open_core(Path("reference"), width=320, height=180) as core:  # builds, starts a worker
        with core.session() as s:                                # a fresh process
            s.call("vector_add", (1, 2, 3), (4, 5, 6)).result    # array([5., 7., 9.])
            core.constants["EPSILON"], core.constants["SPHERE"]  # #define and enum, as floats
            ball = s.call("init_sphere", 0, 0, 0, 1, core.zeros("material")).result
            rays = core.zeros("ray", 1000)                       # fields orig, dir, tmax ...
            hits = core.zeros("intersection", 1000)
            reply = s.call_many("intersect_sphere", 1000, rays, hits, ball)
            reply.result                                         # 1000 bools
            reply.args["r"]["tmax"], reply.args["it"]            # what was written
            s.set("scene", objects)                              # globals: the first items
            s.set("object_count", len(objects))
            s.call("raytrace")
            s.get("output_image")                                # shape (width * height, 3)

Arguments. A value is anything numpy turns into the parameter's dtype (dtypes.py). For a pointer, an
array is copied to memory of its own for each call and comes back in `reply.args`, by the
parameter's name; `None` is NULL; an `Address` is passed as it is (what `octree_build` returned, or
`s.buffer(array)`, memory that stays). In `call_many` the first axis counts the calls; what lacks it
serves for all of them.

Ends. A process that dies, exits or goes on for too long raises `Died`, whose `death` says how and
in which call; a function that the submission lacks raises `Missing`; a mistake of the caller raises
ValueError; a worker that fails by itself raises `MachineError`. A session that died is over; the
next is new. `core.session(Limits(cpu=60))` allows 60 s of CPU to the whole session, and
`s.todo()` gives the exercises whose MRT_TODO was met, even after a crash.

Staying. A session of `Limits(cpu=10, each_call=True)` lasts as long as its block, and each call may
take 10 s. `s.printed_since()` gives what the code has printed since it was last asked. When a
KeyboardInterrupt comes while a call runs, `s.interrupt()` ends the session and tells the function
and the line; a session left without that is over all the same. The worker lives as long as the
thread that opened the core.
"""

from __future__ import annotations

import contextlib
import json
import sys
from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from grader.build.builder import BuildError, build
from grader.build.records import BuildResult, BuildStatus, Target
from grader.course.exercises import ROOT
from grader.execution.crash_location import acts
from grader.execution.dtypes import Types, first, pack, unpack
from grader.execution.marshalling import Address, Array, Reply, packed, unpacked
from grader.execution.records import Act, Death, Limits
from grader.execution.worker_process import (
    Died,
    MachineError,
    Missing,
    SessionSocket,
    WorkerProcess,
    start_worker,
)
from grader.files import write_whole
from grader.intake.submission import read_submission
from grader.worker import frames

# With what callers need of the modules below.
__all__ = [
    "Address",
    "Array",
    "Died",
    "Library",
    "Limits",
    "MachineError",
    "Missing",
    "Reply",
    "Session",
    "open_core",
]

DEFAULT_LIMITS = Limits()


class Library:
    """A loaded library of a submission: types, constants, and sessions that run it."""

    def __init__(self, process: WorkerProcess, library: BuildResult) -> None:
        if library.binding is None:
            raise ValueError("not built")
        self.functions = library.binding.functions
        self.types = Types(library.binding, library.library)
        self.library = library
        self._process = process
        for path in (library.library, library.tables):
            process.declare(path, library.binding.cdef, library.target.sanitized)

    @cached_property
    def constants(self) -> dict[str, float]:
        """The headers' numbers (#define and enum) by their names.

        They come from a library without the submission, which could tell others, and are kept
        beside it. Raises MachineError when C and cffi disagree on a struct.
        """
        kept = Path(self.library.tables).with_suffix(".json")
        try:
            layout, numbers = json.loads(kept.read_text(encoding="utf-8"))
        except (OSError, ValueError, TypeError):
            with self._process.fork(self.library.tables, DEFAULT_LIMITS) as channel:
                layout, numbers = Session(self, channel).read_tables()
            with contextlib.suppress(OSError):  # a cache that cannot be written costs time only
                write_whole(kept, json.dumps([layout, numbers]).encode())
        if tuple(layout) != self.types.layout:
            raise MachineError("the compiler and cffi disagree on the layout of a struct")
        return dict(zip(self.types.binding.constants, map(float, numbers), strict=True))

    def dtype(self, ctype: str) -> np.dtype[Any]:
        """Return the numpy dtype of a C type, such as "ray"."""
        return self.types.dtype(ctype)

    def zeros(self, ctype: str, shape: int | tuple[int, ...] = ()) -> Array:
        """Return an array of that C type, filled with zeros."""
        return np.zeros(shape, self.dtype(ctype))

    @contextlib.contextmanager
    def session(self, limits: Limits = DEFAULT_LIMITS) -> Iterator[Session]:
        """Start a fresh process with the library; end it when the block ends."""
        _ = self.constants  # nothing runs unless the structs' layouts agree
        with self._process.fork(self.library.library, limits) as channel:
            yield Session(self, channel)

    @contextlib.contextmanager
    def lent(self, limits: Limits = DEFAULT_LIMITS) -> Iterator[Session]:
        """Lend a process that may have served before, with all variables as they were first.

        Raises Overdrawn at the end when the block took more than its seconds.
        """
        _ = self.constants
        with self._process.lend(self.library.library, limits) as channel:
            yield Session(self, channel)


class Session:
    """One process that runs the submission's code. Made by Core.session."""

    def __init__(self, core: Library, channel: SessionSocket) -> None:
        self._core, self._channel = core, channel

    def call(self, name: str, *args: Any) -> Reply:
        """Call a function once."""
        reply = self._call(name, 1, args, many=False)
        result: Any = None if reply.result is None else reply.result[0]
        if self._core.functions[name].result.endswith("*"):
            result = Address(result)
        return Reply(result, {key: value[0] for key, value in reply.args.items()})

    def call_many(self, name: str, count: int, *args: Any) -> Reply:
        """Call a function `count` times; the results have `count` as their first axis."""
        return self._call(name, count, args, many=True)

    def get(self, name: str, count: int | None = None) -> Array:
        """Return a global variable; of an array, the first `count` items or all of them."""
        dtype = first(self._variable(name), count)
        head = {"do": "get", "name": name, "size": dtype.itemsize}
        return unpack(self._channel.ask(head, dtype.itemsize), dtype, ())

    def set(self, name: str, value: Any) -> None:
        """Write a global variable; of an array, the first items, as many as `value` has."""
        dtype = self._variable(name)
        dtype = first(dtype, len(value) if dtype.shape else None)
        self._channel.set(name, pack(value, dtype, ()))

    def buffer(self, value: Array) -> Address:
        """Copy an array to memory that stays until the session ends; return its address."""
        reply = self._channel.ask({"do": "buffer"}, 8, np.ascontiguousarray(value).tobytes())
        return Address(int.from_bytes(reply, sys.byteorder))

    def peek(self, address: int, ctype: str, count: int | None = None) -> Array:
        """Read one item, or an array of `count`, of that C type at an address of the process."""
        dtype = self._core.dtype(ctype)
        lead = () if count is None else (count,)
        size = dtype.itemsize * (1 if count is None else count)
        head = {"do": "peek", "address": int(address), "size": size}
        return unpack(self._channel.ask(head, size), dtype, lead)

    def todo(self) -> frozenset[str]:
        """Return the ids of the exercises whose MRT_TODO was met, such as "TP2.4"."""
        marks = self._channel.page()[: frames.TODO_BYTES]
        return frozenset(_exercise(k) for k, mark in enumerate(marks) if mark)

    def acts(self) -> list[Act]:
        """Return the first act that isolation has refused, and the first that it has not."""
        return acts(self._core.library.library, self._channel.page())

    def output(self) -> str:
        """Return the beginning of what the code has printed, without control characters."""
        return self._channel.output()

    def printed_since(self) -> str:
        """Return the beginning of what has been printed since this was last asked.

        `output` forgets it then. Neither the code's lines nor what it prints is lost by a crash.
        """
        return self._channel.printed_since()

    def interrupt(self) -> Death:
        """End the session at once, even in the middle of a call; return where the code was.

        `location` and `function` are "" when it is not known. For the handler of a
        KeyboardInterrupt that cut a call short, or for another thread, whose call then raises Died.
        """
        return self._channel.interrupt()

    def read_tables(self) -> tuple[list[int], list[float]]:
        """Return the sizes and offsets of the structs that the shim holds, and the constants."""
        layout, constants = self.get("mrt_layout"), self.get("mrt_constants")
        return [*map(int, layout)], [*map(float, constants)]

    def _variable(self, name: str) -> np.dtype[Any]:
        binding = self._core.types.binding
        tables = {
            "mrt_layout": f"size_t [{len(self._core.types.layout)}]",
            "mrt_constants": f"double [{len(binding.constants)}]",
        }
        try:
            return self._core.dtype({**binding.variables, **tables}[name])
        except KeyError as error:
            raise ValueError(f"no global variable {name}") from error

    def _call(self, name: str, count: int, args: Sequence[Any], many: bool) -> Reply:
        function = self._core.functions.get(name)
        if function is None or len(args) != len(function.parameters):
            raise ValueError(f"{name}: no such function, or not with {len(args)} arguments")
        arguments = list(packed(self._core.types, function, count, args, many))
        result = self._core.dtype(function.result) if function.result else None
        size = sum(each.size for each in arguments if each.kind == "table")
        plain = result is not None and not function.boxed
        size += result.itemsize * count if result is not None and plain else 0
        head = {
            "do": "call",
            "name": name,
            "function": function.symbol,
            "count": count,
            "parameters": [(each.kind, each.size) for each in arguments],
        }
        data = self._channel.ask(head, size, b"".join(each.payload for each in arguments))
        return unpacked(memoryview(data), result if plain else None, count, arguments)


def _exercise(index: int) -> str:
    """Return the id of a byte of the page of markers: todo.h says where each stands."""
    tp, number = divmod(index, 16)
    return f"TP{tp + 1}.{f'B{number - 8}' if number >= 8 else number}"


@contextlib.contextmanager
def open_core(
    submission: Path,
    width: int = 320,
    height: int = 180,
    *,
    sanitized: bool = False,
    defines: tuple[str, ...] = (),
    cache: Path = ROOT / "build" / "cache",
) -> Iterator[Library]:
    """Build a submission's folder, start a worker and load the library.

    `defines` are further flags such as "-DSCENE_SIZE=600000". Raises BuildError with the compiler's
    messages when the submission does not compile.
    """
    target = Target(width, height, sanitized, defines)
    (result,) = build(read_submission(submission), [target], cache)
    if result.status is not BuildStatus.BUILT or result.rejected:
        raise BuildError("submission.rejected", log=result.log)
    with start_worker(result.preload) as process:
        yield Library(process, result)
