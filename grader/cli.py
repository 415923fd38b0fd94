"""The command line: `python -m grader grade PATH`."""

from __future__ import annotations

import argparse
import importlib.util
import sys
import traceback
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

from grader import expected, history, junit, manifest, page, report, terminal
from grader.bind import BindError
from grader.build import BuildError
from grader.evaluation import report_of
from grader.expected import ExpectedError
from grader.intake import SubmissionError, read_submission
from grader.isolation.levels import Isolation, IsolationError, Level, current, using
from grader.judge import sizes_for
from grader.manifest import Manifest, ManifestError
from grader.plugin import PytestError, SelectionError, run_checks
from grader.process import MachineError
from grader.records import Finding, Report, Told
from grader.texts import LANGUAGES, Texts, preferred
from grader.usage import Parser
from grader.workshop import Workshop

GRADED, BELOW, WRONG_USE, FAILED, INTERRUPTED = 0, 1, 2, 3, 130
HINT_LEVELS = (1, 2, 3)
# Commands with a module of their own, loaded when asked for; release is not in a student's copy.
OTHERS = {
    "batch": ("grader.batch.command", "batch.description"),
    "purge": ("grader.batch.purge", "purge.description"),
    "release": ("grader.dev.release", "release.description"),
    "submit": ("grader.handin", "submit.description"),
    "update": ("grader.update", "update.description"),
}


class UsageError(Told):
    """The command line asks for something that is not there."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code.

    0 graded, 1 below --fail-under, 2 wrong use, 3 the grader or the machine failed.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    try:
        texts = Texts(_language(words))
        if words and words[0] in OTHERS:
            return _other(words, texts)
        options = _parser(texts).parse_args(words)
        return _told(options, texts)
    except ManifestError as error:
        return _complain(str(error), FAILED)
    except KeyboardInterrupt:
        return INTERRUPTED
    except Exception:  # a fault of the grader is never a verdict on the submission
        traceback.print_exc()
        return FAILED


def _other(words: Sequence[str], texts: Texts) -> int:
    """Run a command that has a module of its own; return its exit code."""
    name, _ = OTHERS[words[0]]
    if importlib.util.find_spec(name.rpartition(".")[0]) is None:
        return _complain(texts.say("usage.not_here", command=words[0]), WRONG_USE)
    code: int = importlib.import_module(name).main(words[1:])
    return code


def _told(options: argparse.Namespace, texts: Texts) -> int:
    """Grade; turn what can go wrong into a sentence and an exit code."""
    try:
        return _grade(options, texts)
    except (SubmissionError, UsageError) as error:
        return _complain(texts.say(error.key, **error.values), WRONG_USE)
    except IsolationError as error:
        return _complain(error.sentence(texts), FAILED)
    except Told as error:
        return _complain(texts.say(error.key, **error.values), FAILED)
    except (BindError, MachineError, PytestError) as error:
        return _complain(texts.say("machine.failed", detail=error), FAILED)


def _grade(options: argparse.Namespace, texts: Texts) -> int:
    rules = manifest.load()
    tps = sorted(rules.tps)
    if options.tp is not None and options.tp not in tps:
        raise UsageError("usage.no_tp", tp=options.tp, first=tps[0], last=tps[-1])
    submission = read_submission(options.path, look_around=True)
    if options.expected != expected.FOLDER:
        _verify_answers(options.expected)
    with (
        _isolation(options.isolation) as isolation,
        Workshop(submission, sizes_for(options.tp), options.build / "cache") as workshop,
    ):
        findings = _findings(workshop, rules, options)
        partial = options.tp is not None or bool(options.keyword)
        judged = report_of(workshop, rules, findings, texts, options.hint, partial)
        content = report.as_json(replace(judged, isolation=isolation.level.value), texts)
    folder = options.build / "grade" / ("partial" if content["partial"] else "")
    path = _write(folder, content, judged)
    terminal.show(content, path, texts)
    if content["incomplete"]:
        return FAILED
    return BELOW if content["score"] < options.fail_under else GRADED


def _write(folder: Path, content: dict[str, Any], judged: Report) -> Path:
    """Write the results; return the path of the page."""
    path = folder / "results.json"
    try:
        history.update(folder, content)
        report.write_images(folder, judged.checks)
        report.write(path, content)
        report.write_text(folder / "junit.xml", junit.as_xml(content))
        report.write_text(folder / page.NAME, page.render(content, folder))
    except OSError as error:
        raise BuildError("machine.cannot_write", path=path, error=error.strerror) from error
    return folder / page.NAME


def _isolation(asked: str | None) -> AbstractContextManager[Isolation]:
    """Return the level that was asked for, or the best one. Raises IsolationError."""
    return using(Level(asked)) if asked else nullcontext(current())


def _verify_answers(folder: Path) -> None:
    """Raise UsageError unless the folder is one of expected data."""
    try:
        expected.read_manifest(folder)
    except ExpectedError as error:
        raise UsageError("usage.bad_expected", error=error) from error


def _findings(workshop: Workshop, rules: Manifest, options: argparse.Namespace) -> list[Finding]:
    try:
        return run_checks(workshop, rules, options.tp, options.keyword, options.expected)
    except SelectionError as error:
        names = {check.id.split(".")[1]: None for check in rules.checks().values()}
        key = "usage.bad_keyword" if error.malformed else "usage.no_match"
        raise UsageError(key, keyword=options.keyword, names=", ".join(names)) from error


def _language(words: Sequence[str]) -> str:
    """Return the language of the help itself: what --lang asks for, before all else is read."""
    early = argparse.ArgumentParser(add_help=False)
    early.add_argument("--lang", default="")
    return preferred(early.parse_known_args(words)[0].lang)


def _parser(texts: Texts) -> Parser:
    parser = Parser(texts=texts, prog="python -m grader")
    names = texts.say("usage.command")
    commands = parser.add_subparsers(dest="command", required=True, metavar=names)
    description = texts.say("usage.description")
    grade = commands.add_parser("grade", texts=texts, help=description, description=description)
    for name, (_, key) in OTHERS.items():
        commands.add_parser(name, texts=texts, help=texts.say(key))

    def add(*names: str, key: str, **settings: Any) -> None:
        grade.add_argument(*names, help=texts.say(key), **settings)

    add("path", key="usage.path", type=Path, metavar="PATH")
    add("--tp", key="usage.tp", type=int, metavar="N")
    add("-k", key="usage.keyword", dest="keyword", default="", metavar="EXPR")
    add("--hint", key="usage.hint", type=int, choices=HINT_LEVELS, default=1)
    add("--lang", key="usage.language", choices=LANGUAGES)
    add("--fail-under", key="usage.fail_under", type=float, default=0.0, metavar="POINTS")
    add("--isolation", key="usage.isolation", choices=[each.value for each in Level])
    add("--expected", key="usage.expected", type=Path, default=expected.FOLDER, metavar="DIR")
    add("--build", key="usage.build", type=Path, default=manifest.ROOT / "build", metavar="DIR")
    return parser


def _complain(sentence: str, code: int) -> int:
    print(sentence, file=sys.stderr)
    return code
