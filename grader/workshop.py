"""A submission ready to be judged: its libraries, made in the background, and their workers."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from concurrent.futures import Future
from contextlib import ExitStack
from functools import cache, cached_property, partial
from pathlib import Path
from types import TracebackType

from grader import diagnostics, expected, manifest, substitute, toolchain
from grader.build import Builder, Built
from grader.judge import PICTURE_SIZE, Student
from grader.process import Process, start_worker
from grader.records import BuildResult, BuildStatus, Death, Submission, Target, Verdict
from grader.runner import Core
from grader.shapes import Size
from grader.toolchain import Compiler

Make = Callable[[], BuildResult]  # waits until it is built


class NotBuilt(Exception):
    """The file, or the whole submission, does not compile; `verdict` says it."""

    def __init__(self, verdict: Verdict) -> None:
        super().__init__(verdict.key)
        self.verdict = verdict


def _result(future: Future[Built]) -> BuildResult:
    return future.result().result


class _Kit:
    """The libraries of a submission, and a worker for each kind of them."""

    def __init__(self, sized: Mapping[Size, Make], plain: Make, counted: Make) -> None:
        self.stuck: dict[str, Death] = {}
        self._sized, self._plain, self._counted = sized, plain, counted
        self._cores: dict[str, Core] = {}
        self._workers: dict[str, Process] = {}
        self._stack = ExitStack()

    def start(self, preload: str) -> Process:
        """Return the worker in which that is loaded before everything else."""
        if preload not in self._workers:
            self._workers[preload] = self._stack.enter_context(start_worker(preload))
        return self._workers[preload]

    def close(self) -> None:
        """End the workers."""
        self._stack.close()

    def unit(self, size: Size) -> Core:
        """Return the library for functions, with pictures of that size. Raises NotBuilt."""
        return self._core(self._sized[size]())

    def renderer(self) -> Core:
        """Return the library for whole pictures. Raises NotBuilt."""
        return self._core(self._plain())

    def counter(self) -> Core:
        """Return the library that counts how often objects are tested. Raises NotBuilt."""
        return self._core(self._counted())

    def _core(self, result: BuildResult) -> Core:
        if result.status is not BuildStatus.BUILT:
            raise NotBuilt(Verdict("failure.not_linked"))
        if result.library not in self._cores:
            self._cores[result.library] = Core(self.start(result.preload), result)
        return self._cores[result.library]


class Workshop:
    """The libraries of one submission; a context manager.

    They are made in the background from the beginning: the one for functions first, whose checks
    need not wait for the others. `flags` are added to the compiler's.
    """

    def __init__(
        self,
        submission: Submission,
        sizes: Sequence[Size],
        folder: Path,
        compiler: Compiler | None = None,
        flags: tuple[str, ...] = (),
    ) -> None:
        self.submission = submission
        self._folder = folder  # of what is made
        self._stack = ExitStack()
        self._builder = self._stack.enter_context(Builder(submission, folder, compiler))
        self._flags = flags
        runtime = toolchain.sanitizer_runtime(self._builder.compiler)
        # Wrong accesses to memory show best with the sanitizers.
        self.sanitized = bool(runtime)
        self._first = self._builder.start(Target(*expected.SIZE, self.sanitized, flags))
        # Pictures are drawn as fast as the program draws them.
        self._plain = self._builder.start(Target(*PICTURE_SIZE, defines=flags))
        self._sized = {expected.SIZE: self._first} | {
            size: self._builder.start(Target(*size, self.sanitized, flags), self._first)
            for size in sizes
            if size != expected.SIZE
        }
        self._kit = _Kit(
            {size: partial(_result, future) for size, future in self._sized.items()},
            partial(_result, self._plain),
            lambda: _result(self._counted),
        )
        self._stack.callback(self._kit.close)
        self._kit.start(runtime)

    def __enter__(self) -> Workshop:
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
        """What became of each target, the one for functions first; waits for all of them."""
        return [each.result().result for each in (*self._sized.values(), self._plain)]

    @property
    def rejected(self) -> dict[str, Verdict]:
        """Why files of the submission are not judged, by their names."""
        return {name: why for each in self.builds for name, why in self._why(each).items()}

    def student(self, file: str, folder: Path, own: Collection[str] = ()) -> Student:
        """Return the submission for one check of functions of `file`. Raises NotBuilt.

        `folder` holds the expected data; `own` are the functions that the check is about.
        """
        first = self._first.result().result
        if first.status is not BuildStatus.BUILT:
            raise NotBuilt(Verdict("failure.not_linked"))
        if file in (why := self._why(first)):
            raise NotBuilt(why[file])
        return Student(self._kit, folder, own)

    @contextlib.contextmanager
    def mixed(self, names: Collection[str], folder: Path) -> Iterator[Callable[..., Student]]:
        """Lend the submission with these functions of the reference in the place of its own.

        It has workers of its own: no code of the submission ever runs beside a library that holds
        the reference's version of what it is judged by. What is yielded makes a Student for a
        check, from the functions that the check is about; its sessions raise BuildError when the
        library cannot be made.
        """
        with Builder(substitute.reference(), self._folder, self._builder.compiler) as builder:

            def mix(wait: Callable[[], Built]) -> Make:
                def make() -> BuildResult:
                    built = wait()
                    solution = builder.start(built.job.target).result()
                    return substitute.substituted(built, solution, names)

                return cache(make)

            sized = {size: mix(each.result) for size, each in self._sized.items()}
            kit = _Kit(sized, mix(self._plain.result), mix(lambda: self._counted.result()))
            with contextlib.closing(kit):
                yield lambda own=(): Student(kit, folder, own)

    @cached_property
    def _counted(self) -> Future[Built]:
        """The build that counts; few submissions need it, so it begins when it is asked for."""
        target = Target(*PICTURE_SIZE, defines=self._flags, counted=True)
        return self._builder.start(target, self._plain)

    def _why(self, result: BuildResult) -> dict[str, Verdict]:
        why = {
            name: Verdict("failure.unreadable", {"file": name})
            for name in manifest.load().student
            if name not in self.submission.files and name not in self.submission.missing
        }
        for name, log in result.rejected.items():
            errors = [each for each in diagnostics.read(log) if each.is_error]
            message = f"{errors[0].place}: {errors[0].message}" if errors else log[:200]
            why[name] = Verdict("failure.not_built", {"file": name, "error": message})
        return why
