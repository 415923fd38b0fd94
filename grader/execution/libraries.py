"""A submission ready to be judged: its libraries, made in the background, and their workers.

The compiler starts before this process has numpy and all that follows: they are imported when the
first library is asked for.
"""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from concurrent.futures import Future
from contextlib import ExitStack
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Protocol

from grader.build import diagnostics, substitution, toolchain
from grader.build.builder import Builder, Built
from grader.build.records import BuildResult, BuildStatus, Target
from grader.build.target import MixError
from grader.build.toolchain import Compiler
from grader.course import exercises, sizes
from grader.course.message import Message
from grader.course.sizes import Size
from grader.execution.records import Death
from grader.execution.worker_process import WorkerProcess, start_worker
from grader.intake import originals
from grader.intake.records import Submission
from grader.sandbox.budget import Budget

if TYPE_CHECKING:
    from grader.execution.session import Library

NOT_LINKED = "failure.not_linked"  # of a verdict
Begin = Callable[[], Future[Built]]
Make = Callable[[], BuildResult]  # waits until it is built


class NotBuilt(Exception):
    """The file, or the whole submission, does not compile; `message` says it."""

    def __init__(self, message: Message) -> None:
        super().__init__(message.key)
        self.message = message


def _result(begin: Begin) -> BuildResult:
    return begin().result().result


class LibrarySet(Protocol):
    """The libraries of a submission; each is there when it is asked for, and not before."""

    stuck: dict[str, Death]  # functions that have run out of time, in whatever check
    is_mixed: bool  # whether functions of the reference stand in for some of its own
    kept: dict[tuple[Path, str], Any]  # what checks keep of it for one another

    def unit(self, size: Size) -> Library:
        """Return the library for functions, with pictures of that size. Raises NotBuilt."""

    def probed(self, size: Size) -> Library:
        """Return `unit` with the probe in the place of trace_ray. Raises NotBuilt."""

    def renderer(self) -> Library:
        """Return the library for whole pictures. Raises NotBuilt."""

    def counter(self) -> Library:
        """Return the library that counts how often objects are tested. Raises NotBuilt."""


class _LibrarySet:
    """Libraries as they are built, and a worker for each kind of them."""

    def __init__(
        self,
        sized: Mapping[Size, Make],
        plain: Make,
        counted: Make,
        budget: Budget,
        probed: Callable[[Size], BuildResult] | None = None,
    ) -> None:
        """Libraries without a probe are those in which functions of the reference stand."""
        self.stuck: dict[str, Death] = {}
        self.kept: dict[tuple[Path, str], Any] = {}
        self.is_mixed = probed is None
        self._probed = probed
        self._sized, self._plain, self._counted = sized, plain, counted
        self._budget = budget
        self._cores: dict[str, Library] = {}
        self._workers: dict[str, WorkerProcess] = {}
        self._stack = ExitStack()
        self._making = threading.Lock()  # pictures may be drawn by a thread of their own

    def start(self, preload: str) -> WorkerProcess:
        """Return the worker in which that is loaded before everything else."""
        if preload not in self._workers:
            worker = start_worker(preload, self._budget)
            self._workers[preload] = self._stack.enter_context(worker)
        return self._workers[preload]

    def close(self) -> None:
        """End the workers."""
        self._stack.close()

    def unit(self, size: Size) -> Library:
        """See LibrarySet."""
        return self._core(self._sized[size]())

    def probed(self, size: Size) -> Library:
        """See LibrarySet."""
        if self._probed is None:
            raise NotBuilt(Message(NOT_LINKED))
        return self._core(self._probed(size))

    def renderer(self) -> Library:
        """See LibrarySet."""
        return self._core(self._plain())

    def counter(self) -> Library:
        """See LibrarySet."""
        return self._core(self._counted())

    def _core(self, result: BuildResult) -> Library:
        if result.status is not BuildStatus.BUILT:
            raise NotBuilt(Message(NOT_LINKED))
        from grader.execution.session import Library

        with self._making:
            if result.library not in self._cores:
                self._cores[result.library] = Library(self.start(result.preload), result)
            return self._cores[result.library]


class Libraries:
    """The libraries of one submission; a context manager.

    They are made in the background from the beginning: the one for functions first, whose checks
    need not wait for the others; with `lazy`, the others when they are asked for. `flags` are added
    to the compiler's.
    """

    def __init__(
        self,
        submission: Submission,
        drawn: Sequence[Size],
        folder: Path,
        compiler: Compiler | None = None,
        flags: tuple[str, ...] = (),
        *,
        lazy: bool = False,
    ) -> None:
        self.submission = submission
        self._folder = folder  # of what is made
        self._stack = ExitStack()
        self.budget = Budget()
        self._builder = self._stack.enter_context(
            Builder(submission, folder, compiler, self.budget)
        )
        self._flags = flags
        self._begun: dict[Target, Future[Built]] = {}
        self._beginning = threading.Lock()
        runtime = toolchain.sanitizer_runtime(self._builder.compiler)
        # Wrong accesses to memory show best with the sanitizers.
        self.sanitized = bool(runtime)
        self._first = self._sized(sizes.UNIT)
        self._drawn = {sizes.UNIT: None, **dict.fromkeys(drawn)}
        if not lazy:
            self._plain()
            for size in self._drawn:
                self._sized(size)
        self._set = _LibrarySet(
            {size: partial(_result, partial(self._sized, size)) for size in self._drawn},
            partial(_result, self._plain),
            partial(_result, self._counted),
            self.budget,
            cache(self._probed),
        )
        self._stack.callback(self._set.close)
        self._set.start(runtime)

    def prepare_plain(self, pictures: bool) -> None:
        """Start the worker without sanitizers, and begin the build for pictures if there are some.

        The worker lives no longer than the thread that calls.
        """
        if pictures:
            self._plain()
        self._set.start("")

    def prepare_counted(self, file: str) -> None:
        """Begin the build that counts, unless the file that it is for is as it was handed out."""
        if file not in originals.untouched(self.submission.files, self.submission.in_place):
            self._counted()

    def __enter__(self) -> Libraries:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """End the workers, and what is still being built."""
        self._stack.close()

    @property
    def builds(self) -> list[BuildResult]:
        """What became of each target, the one for functions first; waits for those that began."""
        with self._beginning:
            begun = list(self._begun.items())
        return [each.result().result for target, each in begun if not target.counted]

    @property
    def rejected(self) -> dict[str, Message]:
        """Why files of the submission are not judged, by their names."""
        return {name: why for each in self.builds for name, why in self._why(each).items()}

    def lend(self, file: str, functions: Collection[str] = ()) -> LibrarySet:
        """Return the libraries, for a check of functions of `file`. Raises NotBuilt.

        A header that was left out takes with it the functions that it declares in another way.
        """
        first = self._first.result().result
        if first.status is not BuildStatus.BUILT:
            raise NotBuilt(Message(NOT_LINKED))
        why = self._why(first)
        changed = diagnostics.changed_signatures(first.rejected)
        for name in (file, *(changed[each] for each in functions if each in changed)):
            if name in why:
                raise NotBuilt(why[name])
        return self._set

    @contextlib.contextmanager
    def mixed(self, names: Collection[str]) -> Iterator[LibrarySet]:
        """Lend the submission with these functions of the reference in the place of its own.

        It has workers of its own: no code of the submission ever runs beside a library that holds
        the reference's version of what it is judged by. Its sessions raise NotBuilt when
        these functions do not go with the reference's, and BuildError by the machine's fault.
        """
        with Builder(substitution.reference(), self._folder, self._builder.compiler) as builder:

            def mix(begin: Begin) -> Make:
                def make() -> BuildResult:
                    built = begin().result()
                    solution = builder.start(built.job.target).result()
                    try:
                        return substitution.substituted(built, solution, names)
                    except MixError:
                        return replace(built.result, status=BuildStatus.REJECTED)

                return cache(make)

            sized = {size: mix(partial(self._sized, size)) for size in self._drawn}
            mixed = _LibrarySet(sized, mix(self._plain), mix(self._counted), self.budget)
            with contextlib.closing(mixed):
                yield mixed

    def _probed(self, size: Size) -> BuildResult:
        """Return the library with the probe; REJECTED when it cannot be made."""
        built = self._sized(size).result()
        if built.result.status is BuildStatus.BUILT and substitution.has_tool():
            with contextlib.suppress(MixError):
                return substitution.probed(built)
        return replace(built.result, status=BuildStatus.REJECTED)

    def _sized(self, size: Size) -> Future[Built]:
        """Return the build for functions, with pictures of that size."""
        target = Target(*size, self.sanitized, self._flags)
        return self._build(target, None if size == sizes.UNIT else self._first)

    def _plain(self) -> Future[Built]:
        """Return the build for pictures, which are drawn as fast as the program draws them."""
        return self._build(Target(*sizes.PICTURE, defines=self._flags))

    def _counted(self) -> Future[Built]:
        """Return the build that counts, much of which is that for pictures where there is one."""
        plain = self._begun.get(Target(*sizes.PICTURE, defines=self._flags))
        return self._build(Target(*sizes.PICTURE, defines=self._flags, counted=True), plain)

    def _build(self, target: Target, like: Future[Built] | None = None) -> Future[Built]:
        """Return the build of a target; it begins when it is first asked for."""
        with self._beginning:
            if target not in self._begun:
                self._begun[target] = self._builder.start(target, like)
            return self._begun[target]

    def _why(self, result: BuildResult) -> dict[str, Message]:
        why = {
            name: Message("failure.unreadable", {"file": name})
            for name in exercises.load().student
            if name not in self.submission.files and name not in self.submission.missing
        }
        sources = {name for name in self.submission.files if name.endswith(".c")}
        others = bool(sources - result.rejected.keys())
        for name, log in result.rejected.items():
            # Of a header, what can stay does.
            key = "failure.beside_header" if name.endswith(".h") else "failure.beside"
            beside = Message(key) if others else ""
            errors = diagnostics.errors(log)
            first = f"{errors[0].place}: {errors[0].message}" if errors else log[:200]
            text = " ".join(first.split())
            values: dict[str, object] = {"file": name, "error": text, "beside": beside}
            why[name] = Message("failure.not_built", values)
        return why
