"""`report`: the report again from results.json alone, in any language; nothing is built or run.

python -m grader report PATH [--lang en]
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from grader.console.parser import Parser, language
from grader.console.run import ExitCode, run
from grader.course.texts import LANGUAGES, Texts, preferred
from grader.evaluation.wording import MOST_DIRECT
from grader.files import write_whole
from grader.report import again, page, terminal
from grader.report.again import ResultsError


def main(arguments: Sequence[str]) -> int:
    """Run the command line; return the exit code."""
    texts = Texts(language(arguments))
    parser = Parser(
        texts=texts,
        prog="python -m grader report",
        description=texts.say("again.description"),
    )
    parser.add_argument("path", type=Path, metavar="PATH", help=texts.say("again.path"))
    parser.add_argument("--lang", choices=LANGUAGES, default="", help=texts.say("usage.language"))
    parser.add_argument(
        "--hint",
        type=int,
        choices=range(1, MOST_DIRECT + 1),
        default=0,
        help=texts.say("usage.hint"),
    )
    options = parser.parse_args(arguments)
    return run(lambda: _again(options.path, options.lang, options.hint), texts)


def _again(path: Path, asked: str, hint: int) -> int:
    """Write the page beside the results, and show them. Raises ResultsError."""
    path = path / "results.json" if path.is_dir() else path
    content = again.read(path)
    texts = Texts(preferred(asked, content["language"]))
    place = path.with_name(page.NAME)
    try:
        told = again.told(content, texts, hint)
        whole = page.render(told, path.parent)
        terminal.show(told, place, texts)
    except (LookupError, StopIteration) as error:  # of exercises that there are no more
        raise ResultsError("again.broken", path=path, error=error) from error
    try:
        write_whole(place, whole)
    except OSError as error:
        raise ResultsError("machine.cannot_write", path=place, error=error.strerror) from error
    return ExitCode.DONE
