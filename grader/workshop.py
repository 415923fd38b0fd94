"""A submission ready to be judged: built for each picture size, with one worker."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType

from grader import toolchain
from grader.build import Submission, build
from grader.judge import Student
from grader.process import start_worker
from grader.records import BuildStatus, Death, Target
from grader.runner import Core
from grader.shapes import Size


class NotBuilt(Exception):
    """The submission does not compile: nothing of it can be called."""


class Workshop:
    """The builds of one submission, and one worker for all of them; a context manager."""

    def __init__(self, submission: Submission, sizes: Sequence[Size], cache: Path) -> None:
        self.submission = submission
        compiler = toolchain.find_compiler()
        # Wrong accesses to memory show best with the sanitizers.
        self.sanitized = bool(toolchain.sanitizer_runtime(compiler))
        targets = [Target(width, height, self.sanitized) for width, height in sizes]
        self.builds = build(submission, targets, cache, compiler)
        self._cores: dict[Size, Core] = {}
        self._stuck: dict[str, Death] = {}
        self._stack = ExitStack()

    def __enter__(self) -> Workshop:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._stack.close()

    @property
    def is_built(self) -> bool:
        """Whether every file compiles."""
        return all(each.status is BuildStatus.BUILT for each in self.builds)

    def student(self) -> Student:
        """Return the submission for one check. Raises NotBuilt."""
        if not self.is_built:
            raise NotBuilt
        if not self._cores:
            process = self._stack.enter_context(start_worker(self.builds[0].preload))
            for each in self.builds:
                size = (each.target.width, each.target.height)
                self._cores[size] = Core(process, each)
        return Student(self._cores, self._stuck)
