"""The libraries of a submission as checks get them: each when it is asked for, and its worker."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from grader.build.records import BuildResult, BuildStatus
from grader.course.message import Message
from grader.course.sizes import Size
from grader.execution.loops import Loops
from grader.execution.worker_process import WorkerProcess, start_worker
from grader.sandbox.budget import Budget

if TYPE_CHECKING:
    from grader.execution.session import Library

NOT_LINKED = "failure.not_linked"  # of a verdict
Make = Callable[[], BuildResult]  # waits until it is built


class NotBuilt(Exception):
    """The file, or the whole submission, does not compile; `message` says it."""

    def __init__(self, message: Message) -> None:
        super().__init__(message.key)
        self.message = message


class LibrarySet(Protocol):
    """The libraries of a submission; each is there when it is asked for, and not before."""

    loops: Loops  # of its functions, in whatever check
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


class BuiltLibraries:
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
        self.loops = Loops()
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
