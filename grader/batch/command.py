"""`python -m grader batch DIR --out DIR`: a class graded, and what is given back.

The same command goes on where another was stopped; what is unchanged is not graded again.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from grader.batch import cluster, fresh_inputs, outputs, pool
from grader.batch.contents import some
from grader.batch.discovery import discover
from grader.batch.grade_class import ClassGrading
from grader.batch.last_run import person_of
from grader.batch.preparation import Asked, beside, prepare
from grader.batch.records import BatchError, GradedFiles, Settings, Task
from grader.batch.results_folder import ResultsFolder
from grader.batch.tasks import read_candidate
from grader.console import parser as usage
from grader.console.parser import Parser
from grader.console.run import ExitCode, complain, run
from grader.course import settings as course
from grader.course.settings import Course
from grader.course.texts import LANGUAGES, Texts
from grader.execution.canary import prove
from grader.sandbox import bubblewrap, cores
from grader.sandbox.leftovers import Leftovers
from grader.sandbox.levels import IsolationError, Level, using


def main(arguments: Sequence[str]) -> int:
    """Run the command; return 0, 2 for a wrong use, 3 when a submission could not be graded."""
    texts = Texts(usage.language(arguments))
    options = _parser(texts).parse_args(arguments)

    def act() -> int:
        try:
            return _batch(options, texts)
        except IsolationError as error:
            need = texts.say("batch.need_strong")
            return complain(f"{error.sentence(texts)} {need}", error.code)

    code = run(act, texts)
    if code == ExitCode.INTERRUPTED:
        complain(texts.say("batch.interrupted", out=options.out), code)
    return code


def _batch(options: argparse.Namespace, texts: Texts) -> int:
    rules = _course(options.path)
    if not options.path.exists():
        raise BatchError("batch.no_submissions", path=options.path)
    for path in (options.path, options.out, options.expected):
        if path and bubblewrap.is_system(path.resolve()):
            raise BatchError("batch.seen", path=path)
    level = Level(options.isolation)
    if level is Level.PORTABLE:
        _agree(options.yes, texts)
    if not options.scheduler:
        _prove(level, texts)
    before = Leftovers()
    with ResultsFolder(options.out) as results:
        settings = _settings(options, results, texts)
        unpacked = results.work / "unpacked"
        with results.writing(results.out):
            found = discover(options.path.absolute(), unpacked, results.out)
            readers = [read_candidate(each, settings, unpacked) for each in found.candidates]
        asked = Asked(options.path, rules, options.worksheet, options.names)
        prepared = prepare(readers, found.strays, asked)
        results.claim([person_of(each) for each in prepared.people])
        for each in prepared.notices:
            sys.stderr.write(f"{texts.say(each.key, **each.values)}\n")
        graded = _grading(results, options, settings).grade(readers, texts)
        told = outputs.write_all(results, prepared, graded, texts)
    sys.stdout.write("".join(f"{line}\n" for line in told.lines))
    if level is Level.PORTABLE and (left := before.files()):
        named = {"count": len(left), "paths": some([str(each) for each in left])}
        sys.stdout.write(f"{texts.say('batch.left', **named)}\n")
    return ExitCode.FAILED if told.failed else ExitCode.DONE


def _settings(options: argparse.Namespace, results: ResultsFolder, texts: Texts) -> Settings:
    """Return how to grade, on inputs that no student has seen unless asked. Raises BatchError."""
    expected = str(options.expected.absolute()) if options.expected else ""
    settings = Settings(texts.language, options.isolation, options.hint, expected, options.gallery)
    if expected:
        return settings
    if options.public or not fresh_inputs.are_possible():
        sys.stderr.write(f"{texts.say('batch.on_public')}\n")
        return settings
    with results.writing(results.out / fresh_inputs.FOLDER):
        seed, data = fresh_inputs.prepared(results.out, results.work)
    return replace(settings, seed=seed, fresh=str(data))


def _agree(agreed: bool, texts: Texts) -> None:
    """Say what is not protected, and have it agreed to. Raises BatchError."""
    sys.stderr.write(f"{texts.say('batch.portable')}\n")
    if agreed:
        return
    if not sys.stdin.isatty():
        raise BatchError("batch.portable_flag")
    sys.stderr.write(texts.say("batch.portable_ask"))
    sys.stderr.flush()
    if sys.stdin.readline().strip().casefold() not in ("oui", "yes"):
        raise BatchError("batch.portable_no")


def _course(path: Path) -> Course:
    """Return the settings, those beside the submissions first. Raises ManifestError."""
    own = beside(path) / course.COURSE.name
    rules = course.load()
    return course.beside(rules, own) if own.is_file() else rules


def _prove(level: Level, texts: Texts) -> None:
    """Try what must be refused. Raises IsolationError, CanaryError, BatchError."""
    with using(level):
        proof = prove()
    if not proof.holds:
        acts = " ".join(texts.say(f"canary.{act}") for act in proof.permitted)
        raise BatchError("batch.not_proved", level=level.value, acts=acts)


def _grading(
    results: ResultsFolder, options: argparse.Namespace, settings: Settings
) -> ClassGrading:
    def run(tasks: Iterable[Task]) -> Iterator[GradedFiles]:
        if options.scheduler:
            return cluster.run(tasks, options.scheduler)
        return pool.run(tasks, options.jobs, results.work)

    # Of several machines it is not known which one has failed.
    return ClassGrading(results, run, settings, options.again, settles=not options.scheduler)


def _parser(texts: Texts) -> Parser:
    parser = Parser(
        texts=texts, prog="python -m grader batch", description=texts.say("batch.description")
    )

    def add(*names: str, key: str, **settings: object) -> None:
        parser.add_argument(*names, help=texts.say(key), **settings)  # type: ignore[arg-type]

    add("path", key="batch.path", type=Path, metavar="DIR")
    add("--out", key="batch.out", type=Path, required=True, metavar="DIR")
    add("--jobs", key="batch.jobs", type=usage.jobs, default=cores.usable(), metavar="N")
    add("--scheduler", key="batch.scheduler", default="", metavar="ADDRESS")
    levels = [each.value for each in Level]
    add("--isolation", key="batch.isolation", choices=levels, default=Level.STRONG.value)
    add("--yes", key="batch.yes", action="store_true")
    add("--again", key="batch.again", action="store_true")
    add("--names", key="batch.names", action="store_true")
    add("--gallery", key="batch.gallery", action="store_true")
    add("--worksheet", key="batch.worksheet", type=Path, metavar="CSV")
    add("--hint", key="usage.hint", type=int, choices=(1, 2, 3), default=1)
    add("--lang", key="usage.language", choices=LANGUAGES)
    add("--expected", key="usage.expected", type=Path, metavar="DIR")
    add("--public", key="batch.public", action="store_true")
    return parser
