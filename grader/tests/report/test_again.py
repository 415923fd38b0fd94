"""The report made again from results.json alone, in another language or after a hint was mended."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest

from grader import commands
from grader.authoring.specimens import faulty, mistakes
from grader.build import compiler_run
from grader.course import exercises, texts
from grader.course.exercises import read_toml
from grader.course.message import Message
from grader.course.sizes import sizes_for
from grader.course.texts import Texts
from grader.evaluation.pipeline import report_of, run_checks
from grader.execution.libraries import Libraries
from grader.intake.submission import read_submission
from grader.report import again, page, results, schema
from grader.tests.support.outputs import outputs
from grader.tests.support.reports import every_outcome
from grader.tests.support.sampling import sampled

CRASH = "    *(volatile int *)0 = 3;\n"
TAUGHT = {"fr": "Cherchez la plus petite racine.", "en": "Look for the smaller root."}


@dataclass(frozen=True)
class Run:
    """A grade: what it printed, and the folder of what it wrote."""

    said: str
    folder: Path

    @property
    def content(self) -> dict[str, Any]:
        """The content of results.json."""
        return again.read(self.folder / "results.json")

    @property
    def html(self) -> bytes:
        """The page."""
        return (self.folder / page.NAME).read_bytes()


@pytest.fixture(scope="module")
def wrong(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a submission with a known mistake, a crash, an error, a warning and a given file."""
    files = next(each for each in mistakes.load() if each.id == "shadow_acne").files()
    start = "bool box_overlaps_object(const box *b, const object *obj) {\n"
    assert start in files["octree.c"]
    unset = "    float unset;\n    if (unset > 3.0f) { return false; }\n"
    files["octree.c"] = files["octree.c"].replace(start, start + unset + CRASH)
    files["main.c"] += "int last = 3\n"
    folder = tmp_path_factory.mktemp("rendu") / "core"
    folder.mkdir()
    for name, text in {**files, "scene.c": "/* Mine. */\n"}.items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder


Grade = Callable[[str], Run]
Write = Callable[..., Path]


@pytest.fixture
def grade(wrong: Path, cache: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Grade:
    """Return a function that grades it in a language, each time in the same folder."""

    def run(language: str) -> Run:
        build = outputs(tmp_path / "build", cache)
        words = ["grade", str(wrong), "--tp", "4", "--build", str(build), "--lang", language]
        assert commands.main(words) == 0
        return Run(_without_owner(capsys.readouterr().out), build / "grade" / "partial")

    return run


def _without_owner(said: str) -> str:
    """Return what the report says, without what grading adds where the solution is."""
    return "".join(
        line
        for line in said.splitlines(keepends=True)
        if line.strip() not in {Texts(each).say("batch.on_public") for each in texts.LANGUAGES}
    )


@pytest.mark.long
def test_in_the_other_language_it_is_what_grading_in_it_gives(
    grade: Grade,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Page, terminal and results.json, byte for byte apart from times; nothing is built or run."""
    french, kept = grade("fr"), tmp_path / "kept"
    content = french.content
    shutil.copytree(french.folder, kept)
    english = grade("en")
    expected = english.content
    checks = {each["id"]: each for each in content["checks"]}
    outcomes = {each["outcome"] for each in content["checks"]}
    assert {"passed", "failed", "crashed"} <= outcomes
    assert all((content["build"]["rejected"], content["build"]["advice"], content["notes"]))
    assert any(each["mistakes"] for each in checks.values())
    assert any("pixel" in each for each in checks.values())
    content["graded_at"] = expected["graded_at"]
    for each in expected["checks"]:
        checks[each["id"]]["seconds"] = each["seconds"]
    results.write(english.folder / "results.json", content)

    monkeypatch.setattr(compiler_run, "run_tool", None)
    monkeypatch.setattr("subprocess.Popen", None)
    assert commands.main(["report", str(english.folder), "--lang", "en"]) == 0
    assert capsys.readouterr().out == english.said
    assert (english.folder / page.NAME).read_bytes() == page.render(expected, kept).encode()
    assert json.dumps(again.told(content, Texts("en"))) == json.dumps(expected)


@pytest.mark.parametrize(
    "name", sampled(faulty.NAMES, ("many_errors", "warnings", "no_such_header"))
)
def test_whatever_is_wrong_is_told_again_alike(name: str, submission: Write, cache: Path) -> None:
    """In either language and at another level of help, from what was found once."""
    rules, case = exercises.load(), read_toml(faulty.FOLDER / f"{name}.toml")
    read = read_submission(faulty.write(case, submission))
    with Libraries(read, sizes_for(1), cache) as libraries:
        findings = run_checks(libraries, rules, 1)
        told = [
            results.as_json(
                replace(
                    report_of(libraries, rules, findings, Texts(language), hint),
                    graded_at=0.0,
                    isolation="strong",
                ),
                Texts(language),
            )
            for language, hint in (("fr", 1), ("en", 1), ("en", 3))
        ]
    french, english, direct = (json.loads(json.dumps(each)) for each in told)
    assert list(schema.faults(french)) == []
    assert again.told(french, Texts("en")) == english
    assert again.told(english, Texts("fr")) == french
    assert again.told(french, Texts("en"), hint=3) == direct


@pytest.mark.long
def test_a_mended_hint_is_told(
    grade: Grade, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also one that did not exist: a question, a hint, the sentence of what is wrong."""
    run = grade("fr")
    (failed, *_) = (each for each in run.content["checks"] if each["mistakes"])
    name, key = failed["mistakes"][0], failed["words"]["message"]["key"]
    known = texts.sentences("fr")
    own = {f"mistake.{name}.question": TAUGHT["fr"], key: f"Autrement dit : {known[key]}"}
    monkeypatch.setattr(texts, "sentences", lambda language: known | own)
    assert commands.main(["report", str(run.folder)]) == 0
    said = capsys.readouterr().out
    assert TAUGHT["fr"] in said
    assert "Autrement dit" in said
    assert TAUGHT["fr"].encode() in (run.folder / page.NAME).read_bytes()
    assert TAUGHT["fr"] not in (run.folder / "results.json").read_text(encoding="utf-8")


def test_a_sentence_that_is_known_no_more_stays() -> None:
    """An older project's keys, checks and exercises; a placeholder that has no value."""
    content = every_outcome("fr")
    check = next(each for each in content["checks"] if each["outcome"] == "failed")
    check |= {"id": "tp1.gone.gone", "message": "ancien", "hint": "vieux ?", "note": "ancienne"}
    check["words"] |= {"message": {"key": "gone.away"}, "notes": [{"key": "note.or"}, {"key": "x"}]}
    content["exercises"][0] |= {"id": "TP1.9", "title": "Titre ancien"}
    content["notes"] = ["une note", "et une autre"]
    content["words"]["notes"] = [{"key": "note.skeleton_file"}, {"key": "note.no_main"}]
    told = again.told(content, Texts("en"))
    (kept,) = (each for each in told["checks"] if each["id"] == "tp1.gone.gone")
    assert (kept["message"], kept["hint"], kept["note"]) == ("ancien", "vieux ?", "ancienne")
    assert kept["hints"] == check["hints"] if "hints" in check else "hints" not in kept
    assert told["exercises"][0]["title"] == "Titre ancien"
    assert told["notes"] == ["une note", Texts("en").say("note.no_main")]


def test_results_without_words_are_read(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Schema 1: the sentences stay, what stands around them is in the language."""
    content = every_outcome("fr", tmp_path)
    del content["words"]
    checks = [{k: v for k, v in each.items() if k != "words"} for each in content["checks"]]
    content |= {"schema": 1, "checks": checks}
    results.write(tmp_path / "results.json", content)
    assert commands.main(["report", str(tmp_path / "results.json"), "--lang", "en"]) == 0
    said = capsys.readouterr().out
    assert content["notes"][0] == Texts("fr").say("note.no_main")
    assert content["notes"][0] in said
    assert "Next step" in said


@pytest.mark.parametrize(
    "text",
    [
        *("", "{", "[]", "null", "3", "[" * 100_000, '{"schema": 1}', "\udcff"),
        json.dumps({**every_outcome(), "schema": 3}),
        json.dumps({**every_outcome(), "checks": [{}]}),
        json.dumps(
            {**every_outcome(), "exercises": [{**every_outcome()["exercises"][0], "tp": 7}]}
        ),
    ],
)
def test_what_is_no_results_is_told_in_a_line(
    text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The file, what is wrong with it, and the cure; no page is written."""
    path = tmp_path / "results.json"
    path.write_bytes(text.encode(errors="surrogateescape"))
    assert commands.main(["report", str(tmp_path), "--lang", "en"]) == 2
    said = capsys.readouterr().err
    assert said.startswith(str(path))
    assert said.count("\n") == 1
    assert "make grade" in said
    assert not (tmp_path / page.NAME).exists()


def test_results_that_are_not_there_are_told_in_a_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """With the command that makes them."""
    assert commands.main(["report", str(tmp_path / "nowhere"), "--lang", "fr"]) == 2
    said = capsys.readouterr().err
    assert (said.count("\n"), "make grade" in said, "nowhere" in said) == (1, True, True)


def test_a_message_goes_through_json_and_says_the_same() -> None:
    """Numbers as the language writes them, messages within messages, sentences that follow."""
    inner = Message("place.counted", {"where": Message("place.top_left"), "count": 12})
    message = Message("places.1", {"first": inner}, (Message("note.no_main"),))
    row = json.loads(json.dumps(message.as_row()))
    for language in texts.LANGUAGES:
        assert Texts(language).told(Message.of_row(row)) == Texts(language).told(message)
    late = Message("batch.late", {"days": 2, "penalty": 1.5})
    assert "1,5" in Texts("fr").told(Message.of_row(json.loads(json.dumps(late.as_row()))))
    assert list(schema.faults(row, {"$ref": "#/$defs/message"})) == []
