"""The command line: `python -m grader grade PATH`."""

from __future__ import annotations

import argparse
import importlib.util
import sys
import traceback
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any

from grader.build.room import require_room
from grader.console import parser as usage
from grader.console.parser import Parser, UsageError
from grader.console.run import ExitCode, complain, run
from grader.course import exercises
from grader.course.exercises import ManifestError
from grader.course.sizes import sizes_for
from grader.course.texts import LANGUAGES, Texts
from grader.evaluation import selection
from grader.execution.libraries import Libraries
from grader.intake.submission import read_submission
from grader.sandbox.levels import Isolation, Level, current, using

HINT_LEVELS = (1, 2, 3)
ANNOTATIONS = ("editor", "github")  # grader.report.at_lines.FORMS, which loads later
# Commands with a module of their own, loaded when asked for; some are not in a student's copy.
OTHERS = {
    "alike": ("grader.authoring.alike.command", "alike.description"),
    "batch": ("grader.batch.command", "batch.description"),
    "classroom": ("grader.authoring.forge", "forge.description"),
    "gradescope": ("grader.authoring.gradescope", "gradescope.description"),
    "oral": ("grader.authoring.oral", "oral.description"),
    "purge": ("grader.batch.purge", "purge.description"),
    "report": ("grader.commands.report", "again.description"),
    "release": ("grader.authoring.release", "release.description"),
    "submit": ("grader.commands.submit", "submit.description"),
    "update": ("grader.setup.update", "update.description"),
    "vpl": ("grader.authoring.vpl", "vpl.description"),
    "watch": ("grader.commands.watch", "watch.description"),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code.

    0 graded, 1 below --fail-under, 2 wrong use, 3 the grader or the machine failed.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    try:
        texts = Texts(usage.language(words))
        if words and words[0] in OTHERS:
            return _other(words, texts)
        options = parser(texts).parse_args(words)
        return run(lambda: _grade(options, texts), texts)
    except ManifestError as error:
        return complain(str(error), error.code)
    except KeyboardInterrupt:
        return ExitCode.INTERRUPTED
    except Exception:  # a fault of the grader is never a verdict on the submission
        traceback.print_exc()
        return ExitCode.FAILED


def _other(words: Sequence[str], texts: Texts) -> int:
    """Run a command that has a module of its own; return its exit code."""
    name, _ = OTHERS[words[0]]
    if importlib.util.find_spec(name.rpartition(".")[0]) is None:
        return complain(texts.say("usage.not_here", command=words[0]), ExitCode.WRONG_USE)
    code: int = importlib.import_module(name).main(words[1:])
    return code


def _grade(options: argparse.Namespace, texts: Texts) -> int:
    rules = exercises.load()
    tps = sorted(rules.tps)
    if options.tp is not None and options.tp not in tps:
        raise UsageError("usage.no_tp", tp=options.tp, first=tps[0], last=tps[-1])
    chosen = selection.choose(rules, options.tp, options.keyword)
    submission = read_submission(options.path, look_around=True)
    _verify_answers(options.expected)
    require_room(options.build)
    drawn, cache = sizes_for(options.tp), options.build / "cache"
    with (
        _isolation(options.isolation) as isolation,
        Libraries(
            submission, drawn, cache, lazy=bool(options.keyword), jobs=options.jobs
        ) as libraries,
    ):
        from grader.commands.grade import grade  # while the compiler runs: it takes as long

        content = grade(libraries, rules, chosen, options, isolation, texts)
    if content["incomplete"]:
        return ExitCode.FAILED
    return ExitCode.BELOW if content["score"] < options.fail_under else ExitCode.DONE


def _isolation(asked: str | None) -> AbstractContextManager[Isolation]:
    """Return the level that was asked for, or the best one. Raises IsolationError."""
    return using(Level(asked)) if asked else nullcontext(current())


def _verify_answers(folder: Path) -> None:
    """Raise UsageError unless the folder is the course's or another one of expected data."""
    if folder == exercises.EXPECTED:
        return
    from grader.checking import expected_data

    try:
        expected_data.read_manifest(folder)
    except expected_data.ExpectedError as error:
        raise UsageError("usage.bad_expected", path=error.path) from error


def parser(texts: Texts) -> Parser:
    """Return what reads the command line of a grade."""
    whole = Parser(texts=texts, prog="python -m grader")
    names = texts.say("usage.command")
    commands = whole.add_subparsers(dest="command", required=True, metavar=names)
    description = texts.say("usage.description")
    grade = commands.add_parser("grade", texts=texts, help=description, description=description)
    for name, (_, key) in OTHERS.items():
        commands.add_parser(name, texts=texts, help=texts.say(key))

    def add(*names: str, key: str, **settings: Any) -> None:
        grade.add_argument(*names, help=texts.say(key), **settings)

    add("path", key="usage.path", type=Path, metavar="PATH")
    add("--tp", key="usage.tp", type=usage.tp_number, metavar="N")
    add("-k", key="usage.keyword", dest="keyword", default="", metavar="NAME")
    add("--hint", key="usage.hint", type=int, choices=HINT_LEVELS, default=1)
    add("--lang", key="usage.language", choices=LANGUAGES)
    add("--fail-under", key="usage.fail_under", type=float, default=0.0, metavar="POINTS")
    add("--annotate", key="usage.annotate", choices=ANNOTATIONS)
    add("--isolation", key="usage.isolation", choices=[each.value for each in Level])
    add("--expected", key="usage.expected", type=Path, default=exercises.EXPECTED, metavar="DIR")
    add("--jobs", key="usage.jobs", type=usage.jobs, metavar="N")
    add("--build", key="usage.build", type=Path, default=exercises.ROOT / "build", metavar="DIR")
    add("--brief", key="usage.brief", action="store_true")
    add("--sketch", key="usage.sketch", action="store_true")
    return whole
