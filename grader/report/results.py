"""results.json: what every later stage (terminal, pages, marks) reads. Points, not hundredths."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

import grader
from grader.build import diagnostics
from grader.build.diagnostics import Diagnostic
from grader.build.records import BuildResult, BuildStatus
from grader.checking import reproducer
from grader.course import exercises as manifest
from grader.course.message import Message
from grader.course.texts import Texts
from grader.evaluation.records import CheckResult, ExerciseResult, Outcome, Report
from grader.files import write_whole
from grader.intake import originals
from grader.intake.records import Source, Submission

Row = Mapping[str, Any]  # a part of results.json

SCHEMA = 2  # 1 had sentences alone, without `words`
MAX_LOG = 20_000  # characters of a compiler's output that are kept
MAX_ERRORS = 20
MAX_ERROR_LINES = 12  # source, caret, and a note or two
EXCERPT_LINES = 5  # of the source, on either side of the line of a crash
MAX_COLUMNS = 200  # of such a line
IMAGES = "images"  # folder beside results.json
_IMAGE = re.compile(r"tp\d+(\.\w+)+-[a-z]+\.png")  # what image_name gives


def as_json(report: Report, texts: Texts) -> dict[str, Any]:
    """Return the report as the content of results.json, which results.schema.json describes."""
    counted = [each for each in report.exercises if not each.bonus]
    bonuses = [each for each in report.exercises if each.bonus]
    return {
        "schema": SCHEMA,
        "grader": grader.__version__,
        "language": report.language,
        "graded_at": _moment(report.graded_at),
        "submission": _submission(report.submission),
        "isolation": report.isolation,
        "build": _build(report, texts),
        "notes": list(map(texts.told, report.notes)),
        **_score("score", counted),
        **_score("bonus", bonuses),
        "incomplete": any(each.outcome is Outcome.ERROR for each in report.checks),
        "partial": report.partial,
        "learnt": list(report.learnt),
        "opened_tps": list(report.opened),
        "unjudged_tps": list(report.unjudged),
        "tps": [_tp(tp, counted) for tp in sorted({each.tp for each in counted})],
        "exercises": [_exercise(each, report.checks) for each in report.exercises],
        "checks": [_check(each, report.submission.files) for each in _in_order(report.checks)],
        # Since the last full run: what history.py knows.
        "changes": [],
        "same_files_as": "",
        "history": [],
        "words": _words(report, texts),
    }


def _words(report: Report, texts: Texts) -> dict[str, Any]:
    """Return the messages of the sentences on the submission as a whole, in their order."""
    meanings = enumerate(each.meaning() for each in _errors(report))
    return {
        "notes": [each.as_row() for each in report.notes],
        "advice": [each.as_row() for each in _advice(report.builds)],
        "meanings": {str(place): each.as_row() for place, each in meanings if each},
        "rejected": {name: each.as_row() for name, each in report.rejected.items()},
        "expected": texts.get(reproducer.EXPECTED),
    }


def _errors(report: Report) -> list[Diagnostic]:
    logs = [each.log for each in report.builds if each.log]
    return diagnostics.errors("".join(logs[:1]))[:MAX_ERRORS]


def _in_order(checks: Sequence[CheckResult]) -> list[CheckResult]:
    """Return the checks in the manifest's order: of an exercise, the pictures come last."""
    order = {name: number for number, name in enumerate(manifest.load().checks())}
    return sorted(checks, key=lambda each: order[each.id])


def _moment(seconds: float) -> str:
    moment = datetime.fromtimestamp(seconds, timezone.utc).astimezone()
    return moment.isoformat(timespec="seconds")


def _submission(submission: Submission) -> dict[str, Any]:
    untouched = originals.untouched(submission.files, submission.in_place)
    return {
        "name": submission.name,
        "files": {
            name: hashlib.sha256(content).hexdigest() for name, content in submission.files.items()
        },
        "sources": [_source(each, each.name in untouched) for each in submission.sources],
        "nearby": [_source(each) for each in submission.nearby],
        "refused": [{"path": each.path, "reason": each.reason} for each in submission.refused],
        "changed": list(submission.changed),
    }


def _source(source: Source, untouched: bool = False) -> dict[str, Any]:
    return {
        "name": source.name,
        "path": _text(source.path),
        "modified": _moment(source.modified),
        **({"untouched": True} if untouched else {}),
    }


def _text(path: str) -> str:
    """Return a path as text; its bytes may be none."""
    return path.encode(errors="surrogateescape").decode(errors="replace")


def _build(report: Report, texts: Texts) -> dict[str, Any]:
    built = all(each.status is BuildStatus.BUILT for each in report.builds)
    logs = [each.log for each in report.builds if each.log]
    # Each size warns of the same lines.
    warnings = {warning: None for each in report.builds for warning in _warnings(each)}
    return {
        "ok": built and not report.rejected,
        "warnings": list(warnings),
        "advice": list(map(texts.told, _advice(report.builds))),
        "log": logs[0][:MAX_LOG] if logs else "",
        "errors": [_error(each, texts) for each in _errors(report)],
        "rejected": {name: texts.told(each) for name, each in report.rejected.items()},
        "cxx": list(report.builds[0].cxx),
        "linker": report.builds[0].linker[:MAX_LOG],
    }


def _warnings(result: BuildResult) -> Iterator[str]:
    """Return each warning with its source line and caret."""
    for each in diagnostics.read("\n".join(result.warnings)):
        if not each.is_error:
            yield "\n".join(each.lines)


def _advice(builds: Sequence[BuildResult]) -> list[Message]:
    """Return what the warnings of all the builds mean, where that is known.

    A function that is not used comes last: it tells of work to do more often than of a mistake.
    """
    found = diagnostics.advice("\n".join(line for each in builds for line in each.warnings))
    return sorted(found, key=lambda each: each.key == "advice.unused_function")


def _error(error: Diagnostic, texts: Texts) -> dict[str, Any]:
    meaning = error.meaning()
    return {
        "file": error.file,
        "line": error.line,
        "lines": list(error.lines[:MAX_ERROR_LINES]),
        "meaning": texts.told(meaning) if meaning else "",
    }


def write(path: Path, content: dict[str, Any]) -> None:
    """Write results.json whole. Raises OSError."""
    write_whole(path, laid_out(content))


def laid_out(content: Row) -> str:
    """Return JSON with a line for each entry, and for each item of its lists.

    json's own indentation is written in Python, and takes ten times as long.
    """
    rows = (f" {json.dumps(name)}: {_lines(value)}" for name, value in content.items())
    return "{\n" + ",\n".join(rows) + "\n}\n"


def _lines(value: Any) -> str:
    if not isinstance(value, list) or not value:
        return json.dumps(value, ensure_ascii=False)
    items = (f"  {json.dumps(each, ensure_ascii=False)}" for each in value)
    return "[\n" + ",\n".join(items) + "\n ]"


def _excerpt(location: str, files: Mapping[str, bytes]) -> dict[str, Any]:
    """Return the student's lines around a "file:line"; no lines when that is not one of theirs."""
    name, _, number = location.rpartition(":")
    line = int(number) if number.isdecimal() else 0
    text = files.get(name, b"").decode(errors="replace")
    lines = [each.rstrip("\r") for each in text.split("\n")]
    if not 0 < line <= len(lines):
        return {"line": 0, "first": 0, "lines": []}
    first = max(line - EXCERPT_LINES, 1)
    kept = lines[first - 1 : line + EXCERPT_LINES]
    return {"line": line, "first": first, "lines": [each[:MAX_COLUMNS] for each in kept]}


def _score(name: str, exercises: list[ExerciseResult]) -> dict[str, float]:
    return {
        name: sum(each.points for each in exercises) / 100,
        f"max_{name}": sum(each.max_points for each in exercises) / 100,
    }


def _tp(tp: int, exercises: list[ExerciseResult]) -> dict[str, float]:
    return {"tp": tp, **_score("score", [each for each in exercises if each.tp == tp])}


def _exercise(result: ExerciseResult, checks: Sequence[CheckResult]) -> dict[str, Any]:
    run = sum(each.exercise == result.id for each in checks)
    of = len(manifest.load().exercise(result.id).checks)
    return {
        "id": result.id,
        "tp": result.tp,
        "function": result.function,
        "file": result.file,
        "title": result.title,
        "bonus": result.bonus,
        "outcome": result.outcome.value,
        "points": result.points / 100,
        "max_points": result.max_points / 100,
        **({"part": {"run": run, "of": of}} if run < of else {}),
    }


def hint_rows(hints: Mapping[int, str]) -> list[dict[str, Any]]:
    """Return hints by their level as JSON has them."""
    return [{"level": level, "text": text} for level, text in hints.items()]


def image_name(result: CheckResult, role: str) -> str:
    """Return where a picture of a check stands, beside results.json."""
    return f"{IMAGES}/{result.id}-{role}.png"


def write_images(folder: Path, checks: Sequence[CheckResult]) -> None:
    """Write the pictures of the checks beside results.json, in the place of an earlier run's.

    Nothing else in their folder is touched. Raises OSError.
    """
    written = set()
    for result in checks:
        for role, content in result.images.items():
            write_whole(folder / image_name(result, role), content)
            written.add(folder / image_name(result, role))
    for path in (folder / IMAGES).glob("*.png"):
        if _IMAGE.fullmatch(path.name) and path not in written:
            path.unlink(missing_ok=True)


def _check(result: CheckResult, files: Mapping[str, bytes]) -> dict[str, Any]:
    return {
        "id": result.id,
        "exercise": result.exercise,
        "tp": result.tp,
        "function": result.function,
        "title": result.title,
        "outcome": result.outcome.value,
        "points": result.points / 100,
        "max_points": result.max_points / 100,
        "message": result.message,
        "hint": result.hint,
        "note": result.note,
        "waits_for": list(result.waits_for),
        "location": result.location,
        "excerpt": _excerpt(result.location, files),
        "output": result.output,
        "mistakes": list(result.mistakes),
        "reproducer": result.reproducer,
        "images": {role: image_name(result, role) for role in result.images},
        "seconds": round(result.seconds, 3),
        "words": result.words.as_row(),
        **({"hints": hint_rows(result.hints)} if result.hints else {}),
        **({"places": result.places} if result.places else {}),
        **({"pixel": asdict(result.pixel)} if result.pixel else {}),
    }
