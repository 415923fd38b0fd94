"""`python -m grader purge DIR`: erases the results of a batch, and what it kept."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

from grader.batch.results_folder import NAME, OWN_FILES, OWN_FOLDERS, is_batch
from grader.console.parser import Parser
from grader.console.run import ExitCode, complain
from grader.course.texts import Texts, preferred


def main(arguments: Sequence[str]) -> int:
    """Erase a batch; return the exit code. Files that are not the batch's stay."""
    texts = Texts(preferred())
    parser = Parser(texts=texts, prog="python -m grader purge")
    parser.add_argument("out", type=Path, metavar="DIR", help=texts.say("purge.out"))
    out = parser.parse_args(arguments).out
    if not is_batch(out):
        return complain(texts.say("purge.not_ours", path=out), ExitCode.WRONG_USE)
    try:
        for name in OWN_FOLDERS:
            if (out / name).is_dir():
                shutil.rmtree(out / name)
        for name in (*OWN_FILES, f".{NAME}.lock"):
            (out / name).unlink(missing_ok=True)
        left = len(list(out.iterdir()))
        if not left:
            out.rmdir()
    except OSError as error:
        sentence = texts.say("purge.cannot", path=error.filename or out, error=error.strerror)
        return complain(sentence, ExitCode.FAILED)
    sys.stdout.write(texts.say("purge.left" if left else "purge.done", path=out, count=left) + "\n")
    return ExitCode.DONE
