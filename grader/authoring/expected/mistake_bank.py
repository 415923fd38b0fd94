"""Makes the bank of a folder of expected data: what the checks find wrong in each known mistake.

    python -m grader.authoring.expected.mistake_bank [--out DIR] [--only TP2.2] [--check]

Each mistake of reference/mistakes/ is built and graded as a submission is, on the checks of its own
exercise. `--check` only compares: the bank is that of today's mistakes and suites.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from grader.authoring.specimens import mistakes
from grader.authoring.specimens.grading import exercise_findings
from grader.authoring.specimens.mistakes import Mistake
from grader.checking.expected_data import FOLDER, read_manifest
from grader.course import exercises
from grader.course.exercises import ROOT
from grader.evaluation import recognition
from grader.evaluation.recognition import BANK, KnownMistake
from grader.files import write_whole


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
    store(options.out, only=options.only or "")
    return 0


def store(folder: Path, cache: Path = ROOT / "build" / "cache", only: str = "") -> None:
    """Put the bank into a folder of expected data. Raises ExpectedError, OSError.

    With `only`, an exercise, what the bank holds of the others stays as it is.
    """
    before = recognition.read(folder) if only else {}
    known = {
        each.id: before[each.id]
        if each.id in before and each.exercise != only
        else answers(each, folder, cache)
        for each in mistakes.load()
    }
    content = recognition.encode(known)
    write_whole(folder / BANK, content)
    stored = read_manifest(folder)
    stored["bank"] = {
        "sha256": hashlib.sha256(content).hexdigest(),
        "mistakes": len(known),
        "made_of": fingerprint(folder),
    }
    text = json.dumps(stored, indent=1, ensure_ascii=False) + "\n"
    write_whole(folder / "manifest.json", text)


def check(folder: Path) -> int:
    """Say whether the bank was made from today's mistakes and suites: 0, or 1 when it was not."""
    if read_manifest(folder).get("bank", {}).get("made_of") == fingerprint(folder):
        return 0
    print(f"{folder}: {BANK} was made from other mistakes or suites; run make expected")
    return 1


def answers(mistake: Mistake, folder: Path, cache: Path) -> KnownMistake:
    """Return what the checks of its exercise find wrong in a mistake."""
    findings = exercise_findings(mistake.submission(), mistake.exercise, cache, folder)
    return KnownMistake(mistake.exercise, recognition.signature(findings))


def fingerprint(folder: Path) -> str:
    """Return what stands for the mistakes, and for the suites that they are put to."""
    suites = read_manifest(folder)["files"]
    changed = [(each.id, each.exercise, sorted(each.files().items())) for each in mistakes.load()]
    checks = [name for name, each in exercises.load().checks().items() if not each.is_picture]
    parts = (sorted((name, rules["sha256"]) for name, rules in suites.items()), changed, checks)
    return hashlib.sha256(repr(parts).encode()).hexdigest()


if __name__ == "__main__":
    sys.exit(main())
