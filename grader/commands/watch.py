"""`watch`: grades again each time that one of the C files is saved, until it is interrupted.

python -m grader watch PATH [what grade takes]
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from datetime import datetime
from pathlib import Path

from grader.console.run import ExitCode
from grader.course.texts import Texts, preferred
from grader.files import Marks, marks

# How editors tell when a round begins and ends: .vscode/tasks.json.
BEGINS, ENDS = "== ", "-- "
SECONDS = 0.3  # between two looks


def main(arguments: Sequence[str]) -> int:
    """Run the command line; return the exit code: 2 for a wrong use, 0 when it is interrupted."""
    try:
        return watch(arguments, _grade, lambda: time.sleep(SECONDS))
    except KeyboardInterrupt:
        return ExitCode.DONE


def watch(
    arguments: Sequence[str], grade: Callable[[Sequence[str]], int], wait: Callable[[], None]
) -> int:
    """Grade at once, and after each save; return the exit code of a grade that cannot be asked."""
    texts = Texts(preferred())
    folder = Path(next(iter(arguments), "."))
    seen: Marks | None = None
    while True:
        now = marks(folder)
        if now != seen:
            wait()  # an editor may write in several steps
            if marks(folder) != now:
                continue
            seen = now
            print(f"{BEGINS}{datetime.now():%H:%M:%S}", flush=True)
            if (code := grade(arguments)) == ExitCode.WRONG_USE:
                return code
            print(ENDS + texts.say("watch.waiting"), flush=True)
        wait()


def _grade(arguments: Sequence[str]) -> int:
    return subprocess.run([sys.executable, "-m", "grader", "grade", *arguments]).returncode
