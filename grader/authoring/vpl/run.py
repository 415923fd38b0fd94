"""What vpl_execution does on VPL's execution server.

    python -m grader.authoring.vpl.run ROOT [--table]

ROOT holds the student's files, and the project in a folder of ours. Every line that is printed is a
comment, and the last one is the grade: whatever a submission makes us print, it is none of these.
Where the grade is not finished there is none. --table shows `make grade` in its place.
"""

from __future__ import annotations

import contextlib
import os
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from grader.authoring import autograder
from grader.authoring.vpl import LEFT_OUT, OWN
from grader.console.run import ExitCode, told
from grader.course.message import GraderError
from grader.course.texts import Texts, preferred
from grader.report import vpl


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return 0 when there is a grade."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    texts = Texts(preferred())
    root = Path(words[0])
    try:
        autograder.expect_isolation()
        if "--table" in words:
            return _table(root)
        lines, code = _evaluated(root)
    except (GraderError, OSError) as error:
        lines, code = vpl.comments(told(error, texts)), ExitCode.FAILED
    sys.stdout.write("".join(f"{line}\n" for line in lines))
    return code


def _evaluated(root: Path) -> tuple[list[str], int]:
    """Grade what was handed in; return what VPL reads, and the exit code."""
    with tempfile.TemporaryFile() as said:
        with _instead_of_output(said.fileno()):
            code = autograder.grade(root, root / OWN, LEFT_OUT)
        said.seek(0)
        told = said.read().decode(errors="replace")
    if code:
        return vpl.comments(told), code
    content, _ = autograder.graded(root / OWN)
    most = float(os.environ.get("VPL_GRADEMAX", "100"))
    if content:
        return vpl.as_vpl(content, most), ExitCode.DONE
    return vpl.nothing(autograder.reason(root / OWN)), ExitCode.DONE


@contextlib.contextmanager
def _instead_of_output(file: int) -> Iterator[None]:
    """Have all that is printed here, by processes too, go to a file: VPL reads none of it."""
    kept = [(fd, os.dup(fd)) for fd in (1, 2)]  # no process of ours inherits these
    try:
        for fd, _ in kept:
            os.dup2(file, fd)
        yield
    finally:
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        for fd, old in kept:
            os.dup2(old, fd)
            os.close(old)


def _table(root: Path) -> int:
    from grader.commands import main as grader

    return grader(["grade", str(root), "--build", str(root / OWN / "build")])


if __name__ == "__main__":
    sys.exit(main())
