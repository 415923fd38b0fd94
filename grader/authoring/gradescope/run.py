"""What setup.sh and run_autograder do in Gradescope's container.

    python -m grader.authoring.gradescope.run ROOT [--prepare]

A submission is graded as a class of one by `make batch`, with its budgets and its unseen inputs.
--prepare makes these once, and tries the container, by grading the files that are handed out. Where
the grade is not finished there is no results.json: Gradescope then says that the autograder failed,
and no mark is lost.
"""

from __future__ import annotations

import csv
import json
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

from grader.batch import command
from grader.console.run import ExitCode, complain
from grader.course.exercises import CORE
from grader.course.message import GraderError
from grader.course.texts import Texts, preferred
from grader.files import write_whole
from grader.report import gradescope
from grader.sandbox.levels import Level, current

_CLASS, _NAME = "class", "rendu"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return 0 when there is a result."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    texts = Texts(preferred())
    root = Path(words[0])
    try:
        if current().level is Level.PORTABLE:
            return complain(texts.say("gradescope.no_isolation"), ExitCode.FAILED)
        if "--prepare" in words:
            return _graded(CORE, root / _CLASS)
        return _answered(root)
    except (GraderError, OSError) as error:
        said = error.sentence(texts) if isinstance(error, GraderError) else str(error)
        return complain(said, ExitCode.FAILED)


def _answered(root: Path) -> int:
    """Grade what was handed in, and write what Gradescope reads."""
    if code := _graded(root / "submission", root / _CLASS):
        return code
    path = root / _CLASS / "results" / "students" / _NAME / "results.json"
    if path.is_file():
        told = gradescope.as_gradescope(json.loads(path.read_text(encoding="utf-8")), path.parent)
    else:
        told = gradescope.nothing(_reason(root / _CLASS / "results" / "grades.csv"))
    write_whole(root / "results" / "results.json", json.dumps(told, ensure_ascii=False, indent=1))
    return ExitCode.DONE


def _graded(files: Path, folder: Path) -> int:
    """Grade a folder as a class of one; return the exit code of the batch."""
    handed_in = folder / "handed_in"
    for old in (handed_in, folder / "results" / "students"):
        shutil.rmtree(old, ignore_errors=True)
    shutil.copytree(files, handed_in / _NAME, symlinks=True)
    words = [str(handed_in), "--out", str(folder / "results")]
    return command.main([*words, "--isolation", current().level.value, "--again"])


def _reason(path: Path) -> str:
    """Return why the submission has no mark: the last column of grades.csv."""
    with path.open(encoding="utf-8-sig", newline="") as file:
        rows = list(csv.reader(file, delimiter=";"))
    return rows[-1][-1]


if __name__ == "__main__":
    sys.exit(main())
