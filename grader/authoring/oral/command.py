"""`python -m grader oral PATH`: writes build/oral/NAME.html, and a line for the terminal.

Exit codes: 0 written, 2 wrong use (nothing to ask included), 3 the machine or the grader failed.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from grader.authoring.oral import page
from grader.authoring.oral.choice import choose
from grader.authoring.oral.records import Swapped
from grader.authoring.oral.trials import Laboratory
from grader.build.records import BuildStatus
from grader.console import parser as usage
from grader.console.parser import Parser
from grader.console.run import ExitCode, run
from grader.course import exercises
from grader.course.exercises import ROOT
from grader.course.message import UserError
from grader.course.texts import LANGUAGES, Texts
from grader.files import write_whole
from grader.intake.originals import REFERENCE
from grader.intake.submission import read_submission
from grader.sandbox.levels import current

COUNT, MOST = 5, 20


class OralError(UserError):
    """There is nothing to ask, or no place to write it: a sentence of [oral] in messages/."""

    code = 2


def main(arguments: Sequence[str]) -> int:
    """Run the command; return the exit code."""
    texts = Texts(usage.language(arguments))
    options = _parser(texts).parse_args(arguments)

    def act() -> int:
        print(_write(options, texts))
        return ExitCode.DONE

    return run(act, texts)


def _write(options: argparse.Namespace, texts: Texts) -> str:
    """Write the page; return the line that says so. Raises OralError."""
    missing = [each for each in exercises.load().student if not (REFERENCE / each).is_file()]
    if missing:
        raise OralError("oral.no_reference", path=f"reference/{missing[0]}")
    submission = read_submission(options.path)
    with Laboratory(submission, options.build / "cache", texts) as laboratory:
        _expect_built(laboratory)
        questions = choose(laboratory, options.questions, options.tp)
    if not questions:
        raise OralError("oral.nothing", name=submission.name)
    path = options.build / "oral" / f"{_file_name(submission.name)}.html"
    try:
        write_whole(path, page.render(submission, questions, current().level.value, texts))
    except OSError as error:
        raise OralError("oral.cannot_write", path=path, error=error.strerror) from error
    lines = sum(isinstance(each, Swapped) for each in questions)
    counts = {"count": len(questions), "lines": lines, "values": len(questions) - lines}
    return texts.say("oral.done", name=submission.name, path=path, **counts)


def _expect_built(laboratory: Laboratory) -> None:
    """Raise OralError when no file of the submission compiles."""
    libraries, submission = laboratory.libraries, laboratory.submission
    rejected = libraries.rejected
    sources = {name for name in submission.files if name.endswith(".c")}
    linked = all(each.status is BuildStatus.BUILT for each in libraries.builds)
    if not linked or sources <= set(rejected):
        errors = [str(each.values.get("error", "")) for each in rejected.values()]
        errors += [each.log.strip().partition("\n")[0] for each in libraries.builds]
        why = next(filter(None, errors), ", ".join(sorted(sources)))
        raise OralError("oral.not_built", name=submission.name, why=why)


def _file_name(name: str) -> str:
    """Return a name that any system takes as a file's."""
    return re.sub(r"[^\w.-]+", "_", name).strip(".") or "_"


def _parser(texts: Texts) -> Parser:
    description = texts.say("oral.description")
    parser = Parser(texts=texts, prog="python -m grader oral", description=description)

    def add(*names: str, key: str, **settings: Any) -> None:
        parser.add_argument(*names, help=texts.say(key), **settings)

    add("path", key="oral.path", type=Path, metavar="PATH")
    add("--tp", key="oral.tp", type=int, choices=sorted(exercises.load().tps), metavar="N")
    add("--questions", key="oral.count", type=_count, default=COUNT, metavar="N")
    add("--lang", key="usage.language", choices=LANGUAGES)
    add("--build", key="oral.build", type=Path, default=ROOT / "build", metavar="DIR")
    return parser


def _count(text: str) -> int:
    number = int(text)
    if not 0 < number <= MOST:
        raise ValueError(text)
    return number
