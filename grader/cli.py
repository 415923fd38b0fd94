"""The command line: `python -m grader grade PATH`."""

from __future__ import annotations

import argparse
import hashlib
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path

from grader import manifest, report, terminal
from grader.bind import BindError
from grader.build import BuildError, Submission, SubmissionError, read_submission
from grader.grading import conclude
from grader.judge import SIZES
from grader.manifest import Manifest, ManifestError
from grader.plugin import PytestError, SelectionError, run_checks
from grader.process import MachineError
from grader.records import Finding, Report, Told
from grader.texts import LANGUAGES, Texts, preferred
from grader.toolchain import ToolchainError
from grader.workshop import Workshop

GRADED, WRONG_USE, FAILED, INTERRUPTED = 0, 2, 3, 130
# Until stronger levels exist: limits on time and memory, a process of its own.
ISOLATION = "portable"


class UsageError(Told):
    """The command line asks for something that is not there."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code: 0 graded, 2 wrong use, 3 the grader failed."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    try:
        texts = Texts(_language(words))
        options = _parser(texts).parse_args(words)
        return _told(options, texts)
    except ManifestError as error:
        return _complain(str(error), FAILED)
    except KeyboardInterrupt:
        return INTERRUPTED
    except Exception:  # a fault of the grader is never a verdict on the submission
        traceback.print_exc()
        return FAILED


def _told(options: argparse.Namespace, texts: Texts) -> int:
    """Grade; turn what can go wrong into a sentence and an exit code."""
    try:
        return _grade(options, texts)
    except (SubmissionError, UsageError) as error:
        return _complain(texts.say(error.key, **error.values), WRONG_USE)
    except (BuildError, ToolchainError) as error:
        return _complain(texts.say(error.key, **error.values), FAILED)
    except (BindError, MachineError, PytestError) as error:
        return _complain(texts.say("machine.failed", detail=error), FAILED)


def _grade(options: argparse.Namespace, texts: Texts) -> int:
    rules = manifest.load()
    tps = sorted(rules.tps)
    if options.tp is not None and options.tp not in tps:
        raise UsageError("usage.no_tp", tp=options.tp, first=tps[0], last=tps[-1])
    submission = read_submission(options.path)
    with Workshop(submission, SIZES, options.build / "cache") as workshop:
        findings = _findings(workshop, rules, options)
        content = report.as_json(_report(workshop, rules, findings, options, texts))
    path = options.build / "grade" / ("partial" if content["partial"] else "") / "results.json"
    try:
        report.write(path, content)
    except OSError as error:
        raise BuildError("machine.cannot_write", path=path, error=error.strerror) from error
    terminal.show(content, path, texts)
    return FAILED if content["incomplete"] else GRADED


def _findings(workshop: Workshop, rules: Manifest, options: argparse.Namespace) -> list[Finding]:
    try:
        return run_checks(workshop, rules, options.tp, options.keyword)
    except SelectionError as error:
        names = {check.id.split(".")[1]: None for check in rules.checks().values()}
        key = "usage.bad_keyword" if error.malformed else "usage.no_match"
        raise UsageError(key, keyword=options.keyword, names=", ".join(names)) from error


def _report(
    workshop: Workshop,
    rules: Manifest,
    findings: Sequence[Finding],
    options: argparse.Namespace,
    texts: Texts,
) -> Report:
    checks, exercises = conclude(findings, rules, texts)
    submission = workshop.submission
    judged = {each.tp for each in rules.exercises if each.checks}
    hashes = {
        name: hashlib.sha256(content).hexdigest() for name, content in submission.files.items()
    }
    return Report(
        submission=submission.name,
        files=hashes,
        language=texts.language,
        isolation=ISOLATION,
        builds=tuple(workshop.builds),
        checks=tuple(checks),
        exercises=tuple(exercises),
        notes=tuple(_notes(submission, workshop.sanitized, texts)),
        unjudged=tuple(sorted(set(rules.tps) - judged)),
        partial=options.tp is not None or bool(options.keyword),
    )


def _notes(submission: Submission, sanitized: bool, texts: Texts) -> list[str]:
    notes = []
    if submission.missing:
        notes.append(texts.say("note.skeleton_file", names=", ".join(submission.missing)))
    if submission.refused:
        notes.append(texts.say("note.refused_file", names=", ".join(submission.refused)))
    if not sanitized:
        notes.append(texts.say("note.no_sanitizer"))
    return notes


def _language(words: Sequence[str]) -> str:
    """Return the language of the help itself: what --lang asks for, before all else is read."""
    early = argparse.ArgumentParser(add_help=False)
    early.add_argument("--lang", default="")
    return preferred(early.parse_known_args(words)[0].lang)


def _parser(texts: Texts) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m grader")
    commands = parser.add_subparsers(dest="command", required=True)
    description = texts.say("usage.description")
    grade = commands.add_parser("grade", help=description, description=description)
    grade.add_argument("path", type=Path, metavar="PATH", help=texts.say("usage.path"))
    grade.add_argument("--tp", type=int, metavar="N", help=texts.say("usage.tp"))
    grade.add_argument(
        "-k", dest="keyword", default="", metavar="EXPR", help=texts.say("usage.keyword")
    )
    grade.add_argument("--lang", choices=LANGUAGES, help=texts.say("usage.language"))
    grade.add_argument(
        "--build",
        type=Path,
        default=manifest.ROOT / "build",
        metavar="DIR",
        help=texts.say("usage.build"),
    )
    return parser


def _complain(sentence: str, code: int) -> int:
    print(sentence, file=sys.stderr)
    return code
