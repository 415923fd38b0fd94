"""Local workers: each grades one submission at a time; one that dies is replaced."""

from __future__ import annotations

import contextlib
import math
import os
import shutil
import socket
import subprocess
import sys
import time
from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from pathlib import Path

from grader.batch.records import BatchError, GradedFiles, Task
from grader.course.exercises import ROOT
from grader.course.texts import Texts
from grader.execution.session_report import printable
from grader.sandbox.budget import SECONDS, WALL, Budget
from grader.sandbox.scratch import own_folder
from grader.sandbox.surroundings import cleaned

# For one submission, on a quiet machine: the last of all deadlines, beyond its own budget and what
# is the grader's, which comes before and after.
MOST_SECONDS = 2 * SECONDS[WALL]
LOOK_SECONDS = 1.0
END_SECONDS = 5.0
TRIES = 2
_ENDLESS = dict.fromkeys(SECONDS, math.inf)


@dataclass
class _Worker:
    """A process, and what it does."""

    process: subprocess.Popen[bytes]
    connection: Connection
    temporary: Path
    errors: Path  # what it writes on stderr
    started: bool = False
    task: Task | None = None
    turn: int = 0
    patience: Budget = field(default_factory=Budget.endless)

    def end(self) -> None:
        """Kill it; its sandboxes die with it."""
        self.connection.close()
        self.process.kill()
        self.process.wait(END_SECONDS)
        shutil.rmtree(self.temporary, ignore_errors=True)

    def failed_to_start(self) -> bool:
        """Say whether it has ended by itself before it could be asked for anything."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            return not self.started and self.process.wait(END_SECONDS) > 0
        return False


@dataclass
class _Starts:
    """Whether workers start at all."""

    succeeded: bool = False
    failed: int = 0

    def look_at(self, worker: _Worker) -> None:
        """Count a worker that has ended. Raises BatchError when none has ever started."""
        self.failed += worker.failed_to_start()
        if self.failed >= TRIES and not self.succeeded:
            raise BatchError("batch.no_worker", reason=_last_line(worker.errors))


def run(tasks: Iterable[Task], jobs: int, folder: Path) -> Iterator[GradedFiles]:
    """Grade; yield each bundle when it is known. What fails for the machine is tried once more.

    What gives no answer in time is not: it would take as long again.

    `folder` is for what the workers make, and is there. They are ended with the iterator. Raises
    OSError, and BatchError when none of them starts, with the reason.
    """
    waiting = ((task, 1) for task in tasks)
    again: deque[tuple[Task, int]] = deque()
    workers: list[_Worker] = []
    starts = _Starts()
    with contextlib.ExitStack() as stack:
        stack.callback(_end_all, workers)
        while True:
            _hire(workers, waiting, again, jobs, folder)
            if not (busy := [each for each in workers if each.task]):
                return
            ready = wait([each.connection for each in busy], LOOK_SECONDS)
            for worker in busy:
                late = worker.connection not in ready and bool(worker.patience.spent)
                if worker.connection not in ready and not late:
                    continue
                task, turn = worker.task, worker.turn
                assert task is not None
                if (bundle := _heard(worker, task)) is None:
                    starts.succeeded = True
                    continue
                if worker.task is not None:  # it is dead, or as good as dead
                    starts.look_at(worker)
                    worker.end()
                    workers.remove(worker)
                if bundle.failure and turn < TRIES and not late:
                    again.append((task, turn + 1))
                else:
                    yield bundle


def _end_all(workers: Iterable[_Worker]) -> None:
    for each in workers:
        each.end()


def _hire(
    workers: list[_Worker],
    waiting: Iterator[tuple[Task, int]],
    again: deque[tuple[Task, int]],
    jobs: int,
    folder: Path,
) -> None:
    """Give every free worker something to do, and start one when there is room."""
    while len(free := [each for each in workers if not each.task]) + jobs - len(workers) > 0:
        following = again.popleft() if again else next(waiting, None)
        if following is None:
            return
        if not free:
            free = [_start(folder)]
            workers += free
        worker = free[0]
        worker.task, worker.turn = following
        worker.patience = Budget({**_ENDLESS, WALL: MOST_SECONDS})
        with contextlib.suppress(OSError):  # its death is heard
            worker.connection.send(worker.task)


def _heard(worker: _Worker, task: Task) -> GradedFiles | None:
    """Return what a worker says, None that it has started.

    Its task stays when it cannot say anything any more.
    """
    try:
        if worker.connection.poll():
            bundle: GradedFiles | None = worker.connection.recv()
            worker.started = True
            worker.task = task if bundle is None else None
            return bundle
    except (EOFError, OSError):
        return GradedFiles(task.name, failure=_texts(task).say("batch.worker_gone"))
    return GradedFiles(
        task.name, failure=_texts(task).say("batch.worker_late", seconds=float(MOST_SECONDS))
    )


def _texts(task: Task) -> Texts:
    return Texts(task.settings.language)


def _start(folder: Path) -> _Worker:
    ours, theirs = socket.socketpair()
    place = folder / f"builds-{os.getpid()}-{ours.fileno()}-{time.monotonic_ns()}"
    place.mkdir()
    temporary, errors = _temporary(place), place.with_name(f"{place.name}-stderr")
    with theirs, errors.open("wb") as stderr:
        process = subprocess.Popen(
            [sys.executable, "-m", "grader.batch.pool_worker", str(theirs.fileno()), str(place)],
            cwd=ROOT,
            env={
                **cleaned(os.environ),
                # Compilers are waited for in threads; each would keep memory of its own.
                "MALLOC_ARENA_MAX": "1",
                "OPENBLAS_NUM_THREADS": "1",
                "PYTHONPATH": str(ROOT),
                "TMPDIR": str(temporary),
            },
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=stderr,
            pass_fds=[theirs.fileno()],
            start_new_session=True,  # Ctrl-C is for the one that was asked
        )
    return _Worker(process, Connection(ours.detach()), temporary, errors)


def _last_line(errors: Path) -> str:
    """Return the last line that a worker has written: of a traceback, what it ends with."""
    with contextlib.suppress(OSError, IndexError):
        return printable(errors.read_text(errors="replace")).strip().splitlines()[-1]
    return "?"


def _temporary(place: Path) -> Path:
    """Make a worker's folder of temporary files; what a killed one leaves there goes with OUT.

    Without a sandbox, whom root becomes must come there through all that is above it, and OUT's
    own work is closed to others: so root's lies elsewhere.
    """
    if os.geteuid() == 0:
        return own_folder()
    folder = place.with_name(f"{place.name}-tmp")
    folder.mkdir()
    return folder
