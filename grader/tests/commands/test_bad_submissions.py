"""Submissions that are not as they should be: each gets its sentence, and keeps its points."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from grader import commands
from grader.authoring.specimens.faulty import FOLDER, NAMES, Write, expected, write
from grader.console.run import ExitCode
from grader.course.exercises import read_toml
from grader.tests.support.outputs import outputs
from grader.tests.support.sampling import sampled

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


@pytest.mark.parametrize("name", sampled(NAMES, SAMPLE, SAMPLE[::3]))
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
