"""A submission ready to be judged: built for each picture size, with one worker."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType

from grader import diagnostics, manifest, toolchain
from grader.build import build
from grader.judge import PICTURE_SIZE, Student
from grader.process import start_worker
from grader.records import BuildStatus, Death, Submission, Target, Verdict
from grader.runner import Core
from grader.shapes import Size


class NotBuilt(Exception):
    """The file, or the whole submission, does not compile; `verdict` says it."""

    def __init__(self, verdict: Verdict) -> None:
        super().__init__(verdict.key)
        self.verdict = verdict


class Workshop:
    """The builds of one submission, and one worker for all of them; a context manager."""

    def __init__(self, submission: Submission, sizes: Sequence[Size], cache: Path) -> None:
        self.submission = submission
        compiler = toolchain.find_compiler()
        # Wrong accesses to memory show best with the sanitizers.
        self.sanitized = bool(toolchain.sanitizer_runtime(compiler))
        targets = [Target(width, height, self.sanitized) for width, height in sizes]
        # Pictures are drawn as fast as the program draws them.
        targets.append(Target(*PICTURE_SIZE))
        self.builds = build(submission, targets, cache, compiler)
        self._cores: dict[Size, Core] = {}
        self._renderer: Core | None = None
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
        self.close()

    def close(self) -> None:
        """End the worker."""
        self._stack.close()

    @property
    def is_built(self) -> bool:
        """Whether there is something to judge."""
        return all(each.status is BuildStatus.BUILT for each in self.builds)

    @property
    def rejected(self) -> dict[str, Verdict]:
        """Why files of the submission are not judged, by their names."""
        why = {
            name: Verdict("failure.unreadable", {"file": name})
            for name in manifest.load().student
            if name not in self.submission.files and name not in self.submission.missing
        }
        for result in self.builds:
            for name, log in result.rejected.items():
                errors = [each for each in diagnostics.read(log) if each.is_error]
                message = f"{errors[0].place}: {errors[0].message}" if errors else log[:200]
                why[name] = Verdict("failure.not_built", {"file": name, "error": message})
        return why

    def student(self, file: str, folder: Path) -> Student:
        """Return the submission for one check of a function of `file`. Raises NotBuilt.

        `folder` holds the expected data.
        """
        if not self.is_built:
            raise NotBuilt(Verdict("failure.not_linked"))
        if file in self.rejected:
            raise NotBuilt(self.rejected[file])
        if self._renderer is None:
            process = self._stack.enter_context(start_worker(self.builds[0].preload))
            for each in self.builds[:-1]:
                size = (each.target.width, each.target.height)
                self._cores[size] = Core(process, each)
            plain = self._stack.enter_context(start_worker(""))
            self._renderer = Core(plain, self.builds[-1])
        return Student(self._cores, self._renderer, self._stuck, folder)
