"""What stands beside a submission's code."""

from __future__ import annotations

import subprocess
import sys

from grader.course.exercises import ROOT


def test_the_worker_needs_neither_numpy_nor_the_rest_of_the_grader() -> None:
    """What stands beside a submission's code is small, and knows nothing that is expected of it."""
    code = (
        "import sys; import grader.worker.__main__;"
        "print(*sorted(n for n in sys.modules if n.split('.')[0] in ('grader', 'numpy', 'pytest')))"
    )
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=60, check=True)
    modules = ["__main__", "frames", "lockdown", "session", "shared", "syscalls"]
    files = ["grader", "grader.worker", *(f"grader.worker.{each}" for each in modules)]
    assert done.stdout.split() == files
