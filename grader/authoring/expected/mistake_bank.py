"""Makes the bank of a folder of expected data: what the checks find wrong in each known mistake.

    python -m grader.authoring.expected.mistake_bank [--out DIR] [--only TP2.2] [--check]

Each mistake of reference/mistakes/ is built and graded as a submission is, on the checks of its own
exercise. The manifest has, by mistake, what stands for that: its patch, the checks and the suites
of its exercise. `--check` only compares: the bank is that of today's.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from grader.authoring.expected.manifest import changed, put, write_manifest
from grader.authoring.specimens import mistakes
from grader.authoring.specimens.grading import exercise_findings
from grader.authoring.specimens.mistakes import Mistake
from grader.checking.expected_data import FOLDER, read_manifest
from grader.course import exercises
from grader.course.exercises import ROOT
from grader.evaluation import recognition
from grader.evaluation.recognition import BANK, KnownMistake
from grader.files import content_key

CACHE = ROOT / "build" / "cache"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code: 1 when the bank is not of today."""
    parser = argparse.ArgumentParser(prog="python -m grader.authoring.expected.mistake_bank")
    parser.add_argument("--out", type=Path, default=FOLDER, help="folder (default: %(default)s)")
    parser.add_argument(
        "--only", metavar="ID", help="the mistakes of one exercise; the others stay"
    )
    parser.add_argument("--check", action="store_true", help="compare with what is there")
    options = parser.parse_args(arguments)
    if options.check:
        return check(options.out)
    store(options.out, again=lambda each: options.only in (None, each.exercise))
    return 0


def store(
    folder: Path, cache: Path = CACHE, again: Callable[[Mistake], bool] = lambda mistake: True
) -> None:
    """Put the bank into a folder of expected data. Raises ExpectedError, OSError.

    The mistakes that `again` picks are put to the checks, and those of which the bank is not
    today's; the others keep what it holds.
    """
    stored = read_manifest(folder)
    kept = _made_of(stored)
    before = recognition.read(folder) if kept else {}
    now = {each.id: fingerprint(each, stored["files"]) for each in mistakes.load()}
    known = {
        each.id: before[each.id]
        if kept.get(each.id) == now[each.id] and not again(each)
        else answers(each, folder, cache)
        for each in mistakes.load()
    }
    (rules,) = put(folder, {BANK: recognition.encode(known)}, {"made_of": now}).values()
    write_manifest(folder, {**stored, "bank": rules})


def check(folder: Path) -> int:
    """Say whether the bank was made from today's mistakes and suites: 0, or 1 when it was not."""
    stored = read_manifest(folder)
    now = {each.id: fingerprint(each, stored["files"]) for each in mistakes.load()}
    other = changed(now, _made_of(stored))
    if not other:
        return 0
    print(
        f"{folder}: {BANK} was made from other mistakes or suites: {', '.join(other)};"
        " run make expected"
    )
    return 1


def _made_of(manifest: Mapping[str, Any]) -> dict[str, str]:
    return dict(manifest.get("bank", {}).get("made_of", {}))


def answers(mistake: Mistake, folder: Path, cache: Path) -> KnownMistake:
    """Return what the checks of its exercise find wrong in a mistake."""
    findings = exercise_findings(mistake.submission(), mistake.exercise, cache, folder)
    return KnownMistake(mistake.exercise, recognition.signature(findings))


def fingerprint(mistake: Mistake, suites: Mapping[str, Any]) -> str:
    """Return what stands for a mistake, and for the checks and suites that it is put to.

    A suite is called by a function of its exercise, or by what the checks are about.
    """
    exercise = exercises.load().exercise(mistake.exercise)
    checks = [each for each in exercise.checks if not each.is_picture]
    about = {*exercise.functions, *(each.subject for each in checks)}
    sums = sorted((k, rules["sha256"]) for k, rules in suites.items() if k.split(".")[0] in about)
    return content_key(mistake.exercise, mistake.written, sums, [each.id for each in checks])


if __name__ == "__main__":
    sys.exit(main())
