"""The same work on a Dask cluster that is there already: `--scheduler tcp://host:8786`.

Scheduler and workers need this project at the same version in their PYTHONPATH, and workers one
thread each. One that dies is replaced by another, a few times; what then fails is the machine's
fault.
"""

from __future__ import annotations

import importlib
import itertools
from collections.abc import Iterable, Iterator
from typing import Any

from grader import __version__
from grader.batch.grade_one import grade
from grader.batch.records import BatchError, GradedFiles, Task
from grader.course.exercises import PACKAGE
from grader.files import content_key

CONNECT_SECONDS = 20
MAX_TEXT = 500  # characters of an exception
TRIES = 2
AHEAD = 2  # tasks sent for each worker: the next one is there when it has done one


def run(tasks: Iterable[Task], address: str) -> Iterator[GradedFiles]:
    """Grade on the cluster; yield each bundle when it is known. Raises BatchError."""
    try:
        distributed: Any = importlib.import_module("distributed")
    except ImportError as error:
        raise BatchError("batch.no_dask") from error
    try:
        client = distributed.Client(address, timeout=CONNECT_SECONDS)
    except (OSError, TimeoutError, ValueError) as error:
        raise BatchError("batch.no_scheduler", address=address, error=error) from error
    with client:
        _verify(client)
        yield from _all(client, distributed, iter(tasks))


def version() -> str:
    """Return a name for the project's code as it is here."""
    paths = sorted(path for path in PACKAGE.rglob("*.py") if "tests" not in path.parts)
    return content_key(__version__, [path.read_bytes() for path in paths])


def _verify(client: Any) -> None:
    """Raise BatchError when the scheduler or a worker has not this project, or has another one."""
    for who, ask in (("scheduler", client.run_on_scheduler), ("workers", client.run)):
        try:
            answer = ask(version)
        except Exception as error:  # whatever the other side raised comes back as it is
            text = f"{type(error).__name__}: {error}"[:MAX_TEXT]
            raise BatchError("batch.cluster_without", who=who, error=text) from error
        found = set(answer.values()) if isinstance(answer, dict) else {answer}
        if found - {version()}:
            raise BatchError("batch.cluster_other", who=who)


def _all(client: Any, distributed: Any, tasks: Iterator[Task]) -> Iterator[GradedFiles]:
    turns: dict[Any, tuple[Task, int]] = {}
    done = distributed.as_completed()

    def send(task: Task, turn: int) -> None:
        # pure=False: the same bytes are graded again when asked for again.
        future = client.submit(grade, task, pure=False, retries=TRIES)
        turns[future] = task, turn
        done.add(future)

    room = AHEAD * max(1, len(client.scheduler_info()["workers"]))
    for task in itertools.islice(tasks, room):
        send(task, 1)
    for future in done:
        task, turn = turns.pop(future)
        error = future.exception()
        bundle = (
            GradedFiles(task.name, failure=f"{type(error).__name__}: {error}"[:MAX_TEXT])
            if error
            else future.result()
        )
        future.release()
        if bundle.failure and turn < TRIES:
            send(task, turn + 1)
            continue
        for following in itertools.islice(tasks, 1):
            send(following, 1)
        yield bundle
