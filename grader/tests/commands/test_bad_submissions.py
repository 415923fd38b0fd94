"""Submissions that are not as they should be: each gets its sentence, and keeps what it has earned.

`submissions/NAME.toml` describes one, as changes to a right TP1 (see student.py):
`bodies` of functions, `files` put beside, `absent` files, `given` files copied beside, texts to
`replace` and how files are to be `encode`d; then what is expected: the files that are `lost`, the
functions `missing`, `failed` or `crashed`, one `outcome` for all, what the report `says`
(or `never` does), and in English.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from grader import commands
from grader.console.run import ExitCode
from grader.course import exercises
from grader.course.exercises import read_toml
from grader.tests.support.outputs import outputs
from grader.tests.support.sampling import sampled

FOLDER = Path(__file__).parent / "submissions"
NAMES = sorted(path.stem for path in FOLDER.glob("*.toml"))
# A name that is taken, words of another encoding, a file that is not there, one that is in error...
SAMPLE = (
    *("bom", "broken_header", "changed_signature", "cxx", "everything_broken", "macro_attack"),
    *(
        "missing_file",
        "missing_function",
        "missing_semicolon",
        "refused_acts",
        "taken_name",
        "utf16",
    ),
    *("warnings",),
)
KEYS = {"about", "bodies", "files", "absent", "given", "replace", "encode"}
KEYS |= {"lost", "missing", "failed", "crashed", "outcome", "says", "says_en", "never"}

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


@pytest.mark.parametrize("name", sampled(NAMES, SAMPLE))
def test_bad_submission(
    name: str,
    submission: Write,
    cache: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Its outcomes and its sentences are those that its description expects."""
    case = read_toml(FOLDER / f"{name}.toml")
    assert set(case) <= KEYS
    folder = write(case, submission)
    build = outputs(tmp_path / "build", cache)
    words = ["grade", str(folder), "--build", str(build)]
    assert commands.main([*words, "--lang", "fr", "--tp", "1"]) == ExitCode.DONE
    said = capsys.readouterr().out
    results = json.loads((build / "grade" / "partial" / "results.json").read_text(encoding="utf-8"))
    assert {each["id"]: each["outcome"] for each in results["checks"]} == expected(case)
    assert results["build"]["ok"] is not bool(case.get("lost"))
    for sentence in case.get("says", ()):
        assert sentence in said
    for sentence in case.get("never", ()):
        assert sentence not in said
    if "says_en" in case:
        assert (
            commands.main([*words, "--lang", "en", "-k", case.get("missing", ["fill_red"])[0]]) == 0
        )
        said = capsys.readouterr().out
        for sentence in case["says_en"]:
            assert sentence in said
