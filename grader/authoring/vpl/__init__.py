"""`make vpl`: the execution files of a Moodle VPL activity.

    python -m grader vpl --out ZIP

They are two scripts, and an archive of this project as it is committed, the solution too, with
inputs that nobody has seen. vpl_run.sh shows the table of `make grade`; vpl_evaluate.sh grades.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Sequence
from pathlib import Path

from grader.authoring import autograder, release
from grader.authoring.autograder import TOP
from grader.batch import fresh_inputs
from grader.batch.results_folder import NAME, ResultsFolder
from grader.console.run import ExitCode, complain, told
from grader.course.exercises import ROOT
from grader.course.message import GraderError
from grader.course.texts import Texts, preferred
from grader.files import zipped
from grader.report.vpl import COMMENT

# What VPL runs, by name: what makes a line a comment of the evaluation, and what run.py is asked.
SCRIPTS = {"vpl_run.sh": ("", " --table"), "vpl_evaluate.sh": (f"{COMMENT} ", "")}
PACKAGE = f"{TOP}.zip"
OWN = ".mrt"  # where the scripts unpack the package, beside the student's files
LEFT_OUT = (OWN, PACKAGE, "vpl_*")  # of what lies there, what is not the student's


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    texts = Texts(preferred())
    parser = argparse.ArgumentParser(prog="python -m grader vpl", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--out", type=Path, default=ROOT / "build" / "vpl.zip", metavar="ZIP")
    options = parser.parse_args(arguments)
    try:
        project = autograder.project(ROOT)
        content = zipped(files({**project, **inputs()}), executable=SCRIPTS)
        release.write(options.out, content)
    except (GraderError, OSError) as error:
        return complain(told(error, texts), ExitCode.WRONG_USE)
    size = texts.number(round(len(content) / 1e6, 1))
    print(texts.say("vpl.done", path=options.out, mb=size))
    return ExitCode.DONE


def files(package: dict[str, bytes]) -> dict[str, bytes]:
    """Return the execution files, by name; `package` is what the scripts unpack."""
    pattern = Path(__file__).with_name("vpl.sh").read_text(encoding="utf-8")
    scripts = {
        name: pattern.replace("@COMMENT@", comment).replace("@WORDS@", words).encode()
        for name, (comment, words) in SCRIPTS.items()
    }
    return {PACKAGE: zipped(package), **scripts}


def inputs() -> dict[str, bytes]:
    """Make inputs that nobody has seen; return their files. Raises BatchError, OSError.

    They are made once, here: VPL keeps nothing from one evaluation to the next.
    """
    with tempfile.TemporaryDirectory(prefix="mrt-vpl-") as name:
        top = Path(name)
        with ResultsFolder(autograder.results_of(top)) as results:
            fresh_inputs.prepared(results.out, results.work)
        kept = [results.out / NAME, *(results.out / fresh_inputs.FOLDER).rglob("*")]
        return {str(each.relative_to(top)): each.read_bytes() for each in kept if each.is_file()}
