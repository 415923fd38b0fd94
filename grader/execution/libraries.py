"""A submission ready to be judged: its libraries, made in the background, and their workers.

The compiler starts before this process has numpy and all that follows: they are imported when the
first library is asked for.
"""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Collection, Iterator, Sequence
from concurrent.futures import Future
from contextlib import ExitStack
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from types import TracebackType

from grader.build import diagnostics, substitution, toolchain
from grader.build.builder import Builder, Built
from grader.build.records import BuildResult, BuildStatus, Target
from grader.build.target import MixError
from grader.build.toolchain import Compiler
from grader.course import exercises, sizes
from grader.course.message import Message
from grader.course.sizes import Size
from grader.execution.library_set import NOT_LINKED, BuiltLibraries, LibrarySet, Make, NotBuilt
from grader.intake import originals
from grader.intake.records import Submission
from grader.sandbox import cores
from grader.sandbox.budget import Budget

Begin = Callable[[], Future[Built]]


def _result(begin: Begin) -> BuildResult:
    return begin().result().result


class Libraries:
    """The libraries of one submission; a context manager.

    They are made in the background from the beginning: the one for functions first, whose checks
    need not wait for the others; with `lazy`, the others when they are asked for. `flags` are added
    to the compiler's; `jobs` is how much is done side by side, by default what the processors can.
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
        jobs: int | None = None,
    ) -> None:
        self.submission = submission
        self.jobs = jobs or cores.usable()
        self._folder = folder  # of what is made
        self._stack = ExitStack()
        self.budget = Budget()
        self._builder = self._stack.enter_context(
            Builder(submission, folder, compiler, self.budget, self.jobs)
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
        self._set = BuiltLibraries(
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
            mixed = BuiltLibraries(sized, mix(self._plain), mix(self._counted), self.budget)
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
