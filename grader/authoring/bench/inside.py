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
from grader.execution.libraries import Libraries
from grader.execution.session_socket import SessionSocket
from grader.intake.submission import read_submission
from grader.sandbox.staging import stage
from grader.worker.frames import ROOM_OFFSET

CALL = '            value = function(*[getattr(each, "passed", each) for each in arguments])\n'
TIMED = """\
            passed = [getattr(each, "passed", each) for each in arguments]
            began = time.process_time()
            value = function(*passed)
            seconds = time.process_time() - began
            (before,) = struct.unpack_from("=d", self._shared.page, PLACE)
            struct.pack_into("=d", self._shared.page, PLACE, before + seconds)
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
        run_checks(libraries, exercises.load(), None)
    print(sum(seconds))
    return 0


def _start_stopwatches() -> None:
    """Change this process's copy of what workers run."""
    path = stage() / "grader" / "worker" / "session.py"
    text = path.read_text(encoding="utf-8")
    if text.count(CALL) != 1:
        raise BenchError("grader/worker/session.py has changed: mend CALL in bench/inside.py")
    timed = text.replace(CALL, TIMED).replace("import struct\n", "import struct\nimport time\n")
    path.write_text(timed.replace("PLACE", str(PLACE)), encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
