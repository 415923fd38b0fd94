"""results.json: what every later stage (terminal, pages, marks) reads. Points, not hundredths."""

from __future__ import annotations

import json
import os
import tempfile
from pathlib import Path
from typing import Any

import grader
from grader.records import BuildStatus, CheckResult, ExerciseResult, Outcome, Report

SCHEMA = 1


def as_json(report: Report) -> dict[str, Any]:
    """Return the report as the content of results.json."""
    counted = [each for each in report.exercises if not each.bonus]
    bonuses = [each for each in report.exercises if each.bonus]
    logs = [each.log for each in report.builds if each.log]
    return {
        "schema": SCHEMA,
        "grader": grader.__version__,
        "language": report.language,
        "submission": {"name": report.submission, "files": report.files},
        "isolation": report.isolation,
        "build": {
            "ok": all(each.status is BuildStatus.BUILT for each in report.builds),
            # Each size warns of the same lines.
            "warnings": list(dict.fromkeys(w for each in report.builds for w in each.warnings)),
            "log": logs[0] if logs else "",
        },
        "notes": list(report.notes),
        **_score("score", counted),
        **_score("bonus", bonuses),
        "incomplete": any(each.outcome is Outcome.ERROR for each in report.checks),
        "partial": report.partial,
        "tps": [_tp(tp, counted) for tp in sorted({each.tp for each in counted})],
        "unjudged_tps": list(report.unjudged),
        "exercises": [_exercise(each) for each in report.exercises],
        "checks": [_check(each) for each in report.checks],
    }


def write(path: Path, content: dict[str, Any]) -> None:
    """Write results.json whole: a reader finds the old file or the new one. Raises OSError."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, part = tempfile.mkstemp(dir=path.parent, suffix=".part")
    with os.fdopen(handle, "w", encoding="utf-8") as out:
        json.dump(content, out, ensure_ascii=False, indent=1)
        out.write("\n")
    Path(part).chmod(0o644)
    Path(part).replace(path)


def _score(name: str, exercises: list[ExerciseResult]) -> dict[str, float]:
    return {
        name: sum(each.points for each in exercises) / 100,
        f"max_{name}": sum(each.max_points for each in exercises) / 100,
    }


def _tp(tp: int, exercises: list[ExerciseResult]) -> dict[str, float]:
    return {"tp": tp, **_score("score", [each for each in exercises if each.tp == tp])}


def _exercise(result: ExerciseResult) -> dict[str, Any]:
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
    }


def _check(result: CheckResult) -> dict[str, Any]:
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
        "location": result.location,
        "seconds": round(result.seconds, 3),
    }
