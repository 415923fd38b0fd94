"""Submissions that are not as they should be, each described as changes to a right TP1.

`reference/faulty/NAME.toml` describes one: `bodies` of functions, `files` put beside, `absent`
files, `given` files copied beside, texts to `replace` and how files are to be `encode`d; then what
is expected: the files that are `lost`, the functions `missing`, `failed` or `crashed`, one
`outcome` for all, what the report `says` (or `never` does), and in English.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from grader.course import exercises
from grader.intake.originals import REFERENCE

FOLDER = REFERENCE / "faulty"
NAMES = sorted(path.stem for path in FOLDER.glob("*.toml"))

Write = Callable[..., Path]


def encoded(content: bytes, how: str) -> bytes:
    """Return the content of a file as another editor, or another program, would have it."""
    if how == "crlf":
        return content.replace(b"\n", b"\r\n")
    if how == "binary":
        return bytes(range(256)) * 20
    return content.decode().encode(how)


def write(case: dict[str, Any], submission: Write) -> Path:
    """Write the files of a case; return their folder."""
    files = {name: text.removeprefix("\n") for name, text in case.get("files", {}).items()}
    folder = submission(files, **case.get("bodies", {}))
    for name in case.get("given", []):
        (folder / name).write_bytes((exercises.CORE / name).read_bytes())
    for name in case.get("absent", []):
        (folder / name).unlink()
    for name, old, new in case.get("replace", []):
        text = (folder / name).read_text(encoding="utf-8")
        assert old in text
        (folder / name).write_text(text.replace(old, new, 1), encoding="utf-8")
    for name, how in case.get("encode", {}).items():
        (folder / name).write_bytes(encoded((folder / name).read_bytes(), how))
    return folder


def expected(case: dict[str, Any]) -> dict[str, str]:
    """Return the outcome of each check of TP1."""
    outcomes: dict[str, str] = {}
    for exercise in exercises.load().exercises:
        wrong = exercise.file in case.get("lost", ())
        failed = (*case.get("missing", ()), *case.get("failed", ()))
        wrong = wrong or exercise.functions[0] in failed
        outcome = case.get("outcome", "failed" if wrong else "passed")
        outcome = "crashed" if exercise.functions[0] in case.get("crashed", ()) else outcome
        outcomes |= {check.id: outcome for check in exercise.checks if exercise.tp == 1}
    return outcomes
