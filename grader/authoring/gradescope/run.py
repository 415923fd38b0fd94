"""What setup.sh and run_autograder do in Gradescope's container.

    python -m grader.authoring.gradescope.run ROOT [--prepare]

--prepare makes the inputs that nobody has seen once, and tries the container, by grading the files
that are handed out. Where the grade is not finished there is no results.json: Gradescope then says
that the autograder failed, and no mark is lost.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path

from grader.authoring import autograder
from grader.console.run import ExitCode, complain, told
from grader.course.exercises import CORE
from grader.course.message import GraderError
from grader.course.texts import Texts, preferred
from grader.files import write_whole
from grader.report import gradescope


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return 0 when there is a result."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    texts = Texts(preferred())
    root = Path(words[0])
    try:
        autograder.expect_isolation()
        if "--prepare" in words:
            return autograder.grade(CORE, root)
        return _answered(root)
    except (GraderError, OSError) as error:
        return complain(told(error, texts), ExitCode.FAILED)


def _answered(root: Path) -> int:
    """Grade what was handed in, and write what Gradescope reads."""
    if code := autograder.grade(root / "submission", root):
        return code
    content, folder = autograder.graded(root)
    if content:
        told = gradescope.as_gradescope(content, folder)
    else:
        told = gradescope.nothing(autograder.reason(root))
    write_whole(root / "results" / "results.json", json.dumps(told, ensure_ascii=False, indent=1))
    return ExitCode.DONE


if __name__ == "__main__":
    sys.exit(main())
