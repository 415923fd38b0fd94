"""A machine that is busy with something else."""

from __future__ import annotations

import contextlib
import subprocess
import sys
from collections.abc import Iterator

WEIGHT = 5  # how nice they are
# Each ends by itself when the one that started it is gone.
_BUSY = f"""
import os
os.nice({WEIGHT})
parent = os.getppid()
while os.getppid() == parent:
    sum(range(100_000))
"""


@contextlib.contextmanager
def busy(processes: int) -> Iterator[list[int]]:
    """Keep processes busy meanwhile; yield their ids."""
    with contextlib.ExitStack() as stack:
        started = []
        for _ in range(processes):
            process = subprocess.Popen(
                [sys.executable, "-S", "-c", _BUSY], stdin=subprocess.DEVNULL
            )
            stack.callback(_end, process)
            started.append(process.pid)
        yield started


def _end(process: subprocess.Popen[bytes]) -> None:
    process.kill()
    process.wait(timeout=10)
