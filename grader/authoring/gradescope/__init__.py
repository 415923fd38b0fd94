"""`make gradescope`: the archive that Gradescope builds an autograder from.

    python -m grader gradescope --out ZIP

It holds this project as it is committed, the solution too, and two scripts: setup.sh, run once when
the container is built, and run_autograder, run for each submission (run.py).
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from grader.authoring import autograder, release
from grader.console.run import ExitCode, complain
from grader.course.exercises import ROOT
from grader.course.message import GraderError
from grader.course.texts import Texts, preferred
from grader.files import zipped

SCRIPTS = ("setup.sh", "run_autograder")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    texts = Texts(preferred())
    parser = argparse.ArgumentParser(prog="python -m grader gradescope", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    default = ROOT / "build" / "autograder.zip"
    parser.add_argument("--out", type=Path, default=default, metavar="ZIP")
    options = parser.parse_args(arguments)
    try:
        content = zipped(files(ROOT), executable=SCRIPTS)
        release.write(options.out, content)
    except GraderError as error:
        return complain(error.sentence(texts), ExitCode.WRONG_USE)
    size = texts.number(round(len(content) / 1e6, 1))
    print(texts.say("gradescope.done", path=options.out, mb=size))
    return ExitCode.DONE


def files(root: Path) -> dict[str, bytes]:
    """Return the files by their place in the archive. Raises AutograderError, ReleaseError."""
    scripts = {name: (Path(__file__).parent / name).read_bytes() for name in SCRIPTS}
    return {**scripts, **autograder.project(root)}
