"""A process that grades submissions, one after the other.

Run as `python -m grader.batch.pool_worker FD DIR`. Tasks come and bundles go by the connection of
that descriptor; before them goes None, once it has started. It ends with the process that started
it, and leaves no process of a submission behind, nor, where no sandbox keeps it from that, what is
certainly its own.
"""

from __future__ import annotations

import os
import sys
import threading
import time
from dataclasses import replace
from multiprocessing.connection import Connection
from pathlib import Path

from grader.batch.grade_one import BuildFolder, cpu_seconds, grade
from grader.sandbox import orphans
from grader.sandbox.leftovers import Leftovers
from grader.sandbox.levels import Level

LOOK_SECONDS = 0.5


def main() -> int:
    """Grade until there is nothing more; return the exit code."""
    connection: Connection = Connection(int(sys.argv[1]))
    place = BuildFolder(Path(sys.argv[2]))
    connection.send(None)  # it has started
    threading.Thread(target=_end_with, args=(os.getppid(),), daemon=True).start()
    orphans.guard()
    while True:
        try:
            task = connection.recv()
        except EOFError:
            return 0
        start = cpu_seconds()
        shut_in = Level(task.settings.isolation) is not Level.PORTABLE
        left = None if shut_in else Leftovers()
        bundle = grade(task, place)
        orphans.sweep()  # buries the sandboxes, whose seconds count from then on
        if left:
            left.remove()
        connection.send(replace(bundle, cpu=cpu_seconds() - start))


def _end_with(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(LOOK_SECONDS)
    os._exit(1)  # sandboxes die with this process


if __name__ == "__main__":
    sys.exit(main())
