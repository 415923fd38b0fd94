"""The student's code in processes of its own: built when it was saved, started again when it dies.

A session for each picture size, since the size is chosen when compiling. Whatever goes wrong
raises `Stopped` with what to show, and the next call starts afresh.
"""

from __future__ import annotations

import atexit
import weakref
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from grader.build.builder import build
from grader.build.records import BindError, BuildResult, BuildStatus, Target
from grader.checking.shapes import Size
from grader.course.message import UserError
from grader.evaluation import remarks
from grader.execution import session as runner
from grader.execution.records import OUT_OF_TIME
from grader.execution.session import Session
from grader.execution.worker_process import (
    Died,
    Limits,
    MachineError,
    Missing,
    WorkerProcess,
    start_worker,
)
from grader.files import Marks, marks
from grader.intake.records import Submission
from grader.intake.submission import read_submission
from grader.lab.bridge.idle import Idle
from grader.lab.bridge.saves import SAVES
from grader.lab.display import error_cards
from grader.lab.display.card import Shown
from grader.lab.display.links import outputs
from grader.lab.display.stopped import Stopped, display
from grader.lab.display.words import say, texts

T = TypeVar("T")

SECONDS = 20.0  # of one call; a whole picture may be asked for
SMALL, SECONDS_SMALL = 10_000, 5.0  # a picture of less pixels needs less
SECONDS_AGAIN = 3.0  # once a call has run out of time, until the files change
MOST_SESSIONS = 3


@dataclass
class OpenSession:
    """A session for one picture size, and what it was started with."""

    core: runner.Library
    session: Session
    closing: ExitStack
    seconds: float  # that a call may take
    placed: object = None  # what the scene was last set to; Core compares it
    options: dict[str, Any] = field(default_factory=dict)  # that were last set
    defaults: Any = None  # C's own, as an array


_latest: list[weakref.ref[Engine]] = []


def last_engine() -> Engine | None:
    """Return the engine that was made last, if it is still in use."""
    return _latest[-1]() if _latest else None


class Engine:
    """The builds and the sessions of one folder of C files."""

    def __init__(
        self, folder: Path, *, apart: bool = False, display: Callable[[Shown], object] = display
    ) -> None:
        """Remember the folder; nothing is built yet.

        `apart` is one that a thread of its own uses: `last_engine` never gives it. `display` is
        given what is to be said while the code runs: what it prints, and what is odd of the files.
        """
        self.folder = folder
        self._apart, self._display = apart, display
        self.seconds: float | None = None  # of one call; None: by the picture's size
        self._marks: Marks = ()
        self._files: Mapping[str, bytes] = {}
        self.errors = ""  # the compiler's, of the files as they are
        self._again = False
        self._said: tuple[str, ...] = ()
        self._builds: dict[Target, BuildResult] = {}
        self._stages: dict[Target, OpenSession] = {}
        self._stack = ExitStack()
        self._worker: WorkerProcess | None = None
        self._cores: dict[str, runner.Library] = {}  # by library, of this worker
        self._idle = Idle(self.close)
        if not apart:
            _latest[:] = [weakref.ref(self)]
        atexit.register(self.close)  # the sessions end before their worker

    def close(self) -> None:
        """End the sessions and their worker."""
        self._drop_all()
        self._stack.close()
        self._cores.clear()
        self._worker = None

    def run(
        self, size: Size, call: str, act: Callable[[OpenSession], T], counted: bool = False
    ) -> T:
        """Let `act` use a session; `call` is the C call, for messages. Raises Stopped.

        `counted`: that of the library which counts the tests of objects.
        """
        target = Target(*size, counted=counted)
        stage = self.stage(target)
        try:
            with self._telling(call):
                return self._acted(target, stage, act)
        except KeyboardInterrupt:
            death = stage.session.interrupt()
            self._drop(target)
            raise Stopped(error_cards.interrupted(self.folder, call, death), by_hand=True) from None

    def _acted(self, target: Target, stage: OpenSession, act: Callable[[OpenSession], T]) -> T:
        try:
            try:
                return act(stage)
            finally:
                if printed := error_cards.printed(stage.session):
                    self._display(printed)
        except Died as error:
            self._drop(target)
            self._again |= error.death.cause in OUT_OF_TIME
            raise

    def stage(self, target: Target) -> OpenSession:
        """Return the session of a target, built and started if need be. Raises Stopped."""
        self._idle.used()
        self.refresh()
        try:
            with self._telling(""):
                started = self._stages.get(target)
                if started is None or started.seconds != self.limit(target):
                    self._drop(target)
                    self._start(target)
        except KeyboardInterrupt:
            raise Stopped(error_cards.sentence("lab.build_stopped"), by_hand=True) from None
        return self._stages[target]

    @contextmanager
    def apart(self, target: Target, call: str) -> Iterator[tuple[runner.Library, Session]]:
        """Lend a session that is not kept, for what changes the scene by hand. Raises Stopped."""
        self.refresh()
        with self._telling(call):
            core = self._core(self._judged(target))
            with core.session(Limits(cpu=self.limit(target), each_call=True)) as session:
                yield core, session

    @contextmanager
    def _telling(self, call: str) -> Iterator[None]:
        """Turn what can go wrong in a C call ("": while it is made ready) into Stopped."""
        try:
            yield
        except Died as error:
            raise Stopped(error_cards.died(self.folder, call, error.death)) from None
        except Missing as error:
            raise Stopped(error_cards.sentence("failure.missing", name=error.name)) from None
        except UserError as error:
            raise Stopped(error_cards.sentence(error.key, **error.values)) from None
        except (BindError, MachineError) as error:
            self.close()
            raise Stopped(error_cards.sentence("machine.failed", detail=error)) from None

    def limit(self, target: Target) -> float:
        """Return the seconds that a call may take."""
        small = target.width * target.height < SMALL
        most = self.seconds or (SECONDS_SMALL if small else SECONDS)
        return min(most, SECONDS_AGAIN) if self._again else most

    def refresh(self) -> bool:
        """Look whether a file was saved; forget what was built of the old ones if so."""
        found = marks(self.folder)
        if found == self._marks and self._builds:
            return False
        try:
            submission = read_submission(self.folder)
        except UserError as error:
            raise Stopped(error_cards.sentence(error.key, **error.values)) from None
        if submission.files != self._files:
            self._files = submission.files
            SAVES.note(self.folder, submission.files)
            self.errors, self._again = "", False
            self._builds.clear()
            self.close()
        self._marks = found
        self._submission = submission
        return True

    @property
    def files(self) -> Mapping[str, bytes]:
        """The student's files as they were last read."""
        return self._files

    @property
    def is_endless(self) -> bool:
        """Whether a call has run out of time since the files were saved."""
        return self._again

    def _judged(self, target: Target) -> BuildResult:
        """Return what was built, with all the student's files. Raises Stopped."""
        result = self._built(target)
        if result.status is not BuildStatus.BUILT or result.rejected:
            self.errors = result.log
            head = say("not_built_live" if self._apart else "not_built")
            raise Stopped(error_cards.not_built(self.folder, result, head))
        return result

    def _start(self, target: Target) -> None:
        result = self._judged(target)
        while len(self._stages) >= MOST_SESSIONS:
            self._drop(next(iter(self._stages)))
        core = self._core(result)
        closing = ExitStack()
        seconds = self.limit(target)
        session = closing.enter_context(core.session(Limits(cpu=seconds, each_call=True)))
        self._stages[target] = OpenSession(core, session, closing, seconds)

    def _built(self, target: Target) -> BuildResult:
        if target not in self._builds:
            self._started()
            (result,) = build(self._submission, [target], outputs() / "cache")
            self._builds[target] = result
            self._tell(self._submission, result)
        return self._builds[target]

    def _tell(self, submission: Submission, result: BuildResult) -> None:
        """Say what is odd about the files as a whole, once."""
        said = tuple(map(texts().told, remarks.notes(submission, [result], True)))
        if said != self._said:
            self._said = said
            for each in said:
                self._display(error_cards.remark(each))

    def _core(self, result: BuildResult) -> runner.Library:
        """Return a library made known to the worker."""
        # Declared once: its file would be written again under the sessions that have it loaded.
        if result.library not in self._cores:
            self._cores[result.library] = runner.Library(self._started(), result)
        return self._cores[result.library]

    def _started(self) -> WorkerProcess:
        """Return the worker of these files; it starts while they are compiled."""
        if self._worker is None:
            self._worker = self._stack.enter_context(start_worker())
        return self._worker

    def _drop(self, target: Target) -> None:
        stage = self._stages.pop(target, None)
        if stage is not None:
            stage.closing.close()

    def _drop_all(self) -> None:
        for target in list(self._stages):
            self._drop(target)
