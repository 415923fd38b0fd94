"""CPU seconds inside a submission's own functions while all its checks run; prints the number.

    python -m grader.authoring.bench.inside SUBMISSION CACHE

A process of its own: what its workers run is its own copy of session.py, with a stopwatch around
each call, whose sum stands at the end of the session's shared page.
"""

from __future__ import annotations

import os
import struct
import sys
from pathlib import Path

from grader.authoring.bench.programs import BenchError
from grader.course import exercises
from grader.course.sizes import sizes_for
from grader.evaluation.pipeline import run_checks
from grader.evaluation.records import Outcome
from grader.execution.libraries import Libraries
from grader.execution.session_socket import SessionSocket
from grader.intake.submission import read_submission
from grader.sandbox.staging import stage
from grader.worker.frames import ROOM_OFFSET

CALL = 'function(*[getattr(each, "passed", each) for each in arguments])'
TIMED = CALL.replace("function(*", "timed(self._shared.page, function, ")
STOPWATCH = """
def timed(page, function, arguments):
    began = time.process_time()
    try:
        return function(*arguments)
    finally:
        seconds = time.process_time() - began
        (before,) = struct.unpack_from("=d", page, PLACE)
        struct.pack_into("=d", page, PLACE, before + seconds)
"""
PLACE = ROOM_OFFSET - 8  # nothing else stands there


def main() -> int:
    """Run the checks of a submission; print the seconds."""
    submission, cache = map(Path, sys.argv[1:])
    _start_stopwatches()
    seconds: list[float] = []
    close = SessionSocket.close

    def read_and_close(self: SessionSocket) -> None:
        seconds.extend(struct.unpack("=d", os.pread(self._files[2].fileno(), 8, PLACE)))
        close(self)

    SessionSocket.close = read_and_close  # type: ignore[method-assign]
    with Libraries(read_submission(submission), sizes_for(None), cache) as libraries:
        findings = run_checks(libraries, exercises.load(), None)
    if wrong := [each for each in findings if each.outcome is not Outcome.PASSED]:
        raise BenchError(f"{wrong[0].check}: {wrong[0].outcome.value} {wrong[0].message}")
    print(sum(seconds))
    return 0


def _start_stopwatches() -> None:
    """Change this process's copy of what workers run."""
    path = stage() / "grader" / "worker" / "session.py"
    path.write_text(with_stopwatch(path.read_text(encoding="utf-8")), encoding="utf-8")


def with_stopwatch(text: str) -> str:
    """Return a session's module that sums the CPU seconds of its calls. Raises BenchError."""
    if text.count(CALL) != 1:
        raise BenchError("grader/worker/session.py has changed: mend CALL in bench/inside.py")
    timed = text.replace(CALL, TIMED).replace("import struct\n", "import struct\nimport time\n")
    return timed + STOPWATCH.replace("PLACE", str(PLACE))


if __name__ == "__main__":
    sys.exit(main())
