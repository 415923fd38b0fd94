"""`python -m grader alike DIR`: writes alike.html and alike.json to the folder of results.

Exit codes: 0 written, 2 wrong use (nothing to compare included), 3 the machine failed.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from grader.authoring.alike import page, tools
from grader.authoring.alike.page import Compared
from grader.authoring.alike.pieces import pieces
from grader.authoring.alike.sharing import Program, pairs
from grader.authoring.alike.tools import AlikeError
from grader.authoring.specimens import variants
from grader.batch import contents, roster
from grader.batch.alike_list import NAME, PAGE
from grader.batch.contents import some
from grader.batch.discovery import discover
from grader.batch.names import digits_of, key_of
from grader.batch.records import BatchError
from grader.batch.results_folder import ResultsFolder
from grader.console import parser as usage
from grader.console.parser import Parser
from grader.console.run import ExitCode, complain, run
from grader.course.exercises import ROOT
from grader.course.texts import LANGUAGES, Texts
from grader.files import write_whole
from grader.intake import originals
from grader.intake.authors import Authors
from grader.intake.originals import REFERENCE
from grader.report.results import write

INDEPENDENT = REFERENCE / "independent"


@dataclass(frozen=True)
class Handed:
    """A program that was handed in, by the name of its submission, and whose it is."""

    name: str
    program: Program
    people: frozenset[str]


def main(arguments: Sequence[str]) -> int:
    """Run the command; return the exit code."""
    texts = Texts(usage.language(arguments))
    options = _parser(texts).parse_args(arguments)

    def act() -> int:
        print(_compare(options, texts))
        return ExitCode.DONE

    return run(act, texts)


def _compare(options: argparse.Namespace, texts: Texts) -> str:
    """Write what is alike; return the line that says so. Raises AlikeError, BatchError."""
    name, tool = tools.found()
    for path in (options.path, *options.past):
        if not path.exists():
            raise BatchError("batch.no_submissions", path=path)
    with ResultsFolder(options.out) as results:
        now = _read(options.path, results, "", texts)
        past = [
            each
            for path in options.past
            for each in _read(path, results, f"{path.resolve().name}/", texts)
        ]
        if not now or len(now) + len(past) < 2:
            raise AlikeError("alike.few", path=options.path, count=len(now))
        handed = [*now, *past]
        programs = [each.program for each in handed]
        usual = [*usual_ways()]
        found = pairs(programs, usual, tool, len(past))
        apart = [each for each in found if not handed[each.one].people & handed[each.other].people]
        hidden = results.pseudonyms(each.name for each in handed)
        names = [(each.name, hidden[each.name]) for each in handed]
        alone = page.most_lines(independent(), usual, tool)
        compared = Compared(names, programs, apart, alone, len(past), name)
        with results.writing(results.out):
            write_whole(results.out / PAGE, page.render(compared, options.names, texts))
            write(results.out / NAME, page.as_json(compared))
    path = options.out / PAGE
    return texts.say("alike.done", count=len(now), past=len(past), tool=name, path=path)


def _read(path: Path, results: ResultsFolder, before: str, texts: Texts) -> list[Handed]:
    """Return the programs of a class; say which ones cannot be read. Raises BatchError."""
    handed, left = [], []
    with results.writing(results.out):
        work = Path(tempfile.mkdtemp(dir=results.work))
        for each in discover(path.absolute(), work, results.out).candidates:
            candidate, submission = contents.read(each, work)
            if submission is None:
                left.append(candidate.label)
                continue
            people = _people(roster.read(submission.authors))
            handed.append(Handed(before + candidate.name, pieces(submission.files), people))
    if left:
        complain(texts.say("alike.left_out", path=path, names=some(left)), ExitCode.DONE)
    return handed


def _people(found: Authors | None) -> frozenset[str]:
    """Return who has signed a submission, as it is compared with another's."""
    people = found.people if found else ()
    return frozenset(
        digits_of(each.number) or key_of(f"{each.first_name} {each.surname}") for each in people
    ) - {""}


def usual_ways() -> Iterator[Program]:
    """Yield what nobody needs to copy: what is handed out, and the right programs of the course."""
    yield pieces(originals.from_core())
    for each in variants.load():
        yield pieces(_encoded(each.files()))


def independent() -> list[Program]:
    """Return the programs that were written apart from one another, from the contracts alone."""
    return [pieces({"raytracer.c": path.read_bytes()}) for path in sorted(INDEPENDENT.glob("*.c"))]


def _encoded(files: Mapping[str, str]) -> dict[str, bytes]:
    return {name: text.encode() for name, text in files.items()}


def _parser(texts: Texts) -> Parser:
    description = texts.say("alike.description")
    parser = Parser(texts=texts, prog="python -m grader alike", description=description)

    def add(*names: str, key: str, **settings: object) -> None:
        parser.add_argument(*names, help=texts.say(key), **settings)  # type: ignore[arg-type]

    add("path", key="batch.path", type=Path, metavar="DIR")
    add("--out", key="alike.out", type=Path, default=ROOT / "build" / "alike", metavar="DIR")
    add("--past", key="alike.past", type=Path, action="append", default=[], metavar="DIR")
    add("--names", key="alike.names", action="store_true")
    add("--lang", key="usage.language", choices=LANGUAGES)
    return parser
