"""results.json as its schema says, junit.xml, and what the options of a run change."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from grader import commands
from grader.build import toolchain
from grader.build.records import BuildResult, BuildStatus, Target
from grader.build.toolchain import Compiler
from grader.checking import expected_data
from grader.console.run import ExitCode
from grader.course import exercises, settings
from grader.course.exercises import ManifestError
from grader.course.message import Message
from grader.course.texts import LANGUAGES, Texts
from grader.evaluation.grading import grade
from grader.evaluation.records import Finding, Outcome
from grader.report import junit, results, schema
from grader.tests.support.outputs import outputs
from grader.tests.support.reports import HOSTILE, PNG, every_outcome

SCHEMA = schema.whole()
RULES = exercises.load()
WORDS = {"$schema", "$defs", "$ref", "title", "description", "format", "type", "const", "enum"}
WORDS |= {"minimum", "pattern", "required", "properties", "additionalProperties", "items"}

Write = Callable[..., Path]


def keywords(schema: dict[str, Any]) -> Iterator[str]:
    """Yield the words of JSON Schema that a schema uses."""
    yield from schema
    inside = [*schema.get("properties", {}).values(), *schema.get("$defs", {}).values()]
    inside += [schema[name] for name in ("items", "additionalProperties") if name in schema]
    for each in inside:
        if isinstance(each, dict):
            yield from keywords(each)


def test_the_schema_uses_words_that_are_looked_at() -> None:
    """The validator knows every word that the schema holds."""
    assert set(keywords(SCHEMA)) <= WORDS


def test_the_schema_describes_a_whole_report() -> None:
    """Every field is described, and nothing else is there; it goes through JSON unchanged."""
    content = every_outcome()
    assert list(schema.faults(content)) == []
    assert {each["outcome"] for each in content["checks"]} == {each.value for each in Outcome}
    assert json.loads(json.dumps(content, ensure_ascii=False)) == content


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"schema": 3}, "$.schema: not one of [1, 2]"),
        ({"score": -1}, "$.score: below 0"),
        ({"notes": [3]}, "$.notes[0]: not of type string"),
        ({"partial": 1}, "$.partial: not of type boolean"),
        ({"else": 1}, "$.else: unknown"),
    ],
)
def test_the_schema_refuses_what_is_not_one(change: dict[str, Any], fault: str) -> None:
    """The validator of these tests sees what is wrong."""
    assert list(schema.faults({**every_outcome(), **change})) == [fault]


def test_compiler_messages_come_with_their_meaning() -> None:
    """Errors first, apart from warnings, in both languages."""
    build = every_outcome()["build"]
    (error,) = build["errors"]
    assert (error["file"], error["line"], len(error["lines"])) == ("main.c", 7, 3)
    assert error["meaning"].startswith("Il manque sans doute un point-virgule")
    assert build["warnings"] == ["main.c:9:1: warning: unused variable ‘y’ [-Wunused-variable]"]
    (english,) = every_outcome("en")["build"]["errors"]
    assert english["meaning"].startswith("A semicolon is probably missing")


def test_a_function_that_is_not_used_is_told_last() -> None:
    """Who has stubs left has many of them: a value that is not set must not be lost among these."""
    warnings = (
        "main.c:3:12: warning: ‘f’ defined but not used [-Wunused-function]",
        "main.c:9:5: warning: ‘x’ is used uninitialized [-Wuninitialized]",
        "main.c:12:9: warning: unused variable ‘y’ [-Wunused-variable]",
    )
    build = BuildResult(BuildStatus.BUILT, Target(96, 64), warnings=warnings)
    assert [each.key for each in results._advice([build])] == [
        "advice.unset",
        "advice.unused_variable",
        "advice.unused_function",
    ]


def test_junit_has_a_case_per_check() -> None:
    """Failures, errors and what is not done apart; no character that XML cannot hold."""
    text = junit.as_xml(every_outcome())
    root = ElementTree.fromstring(text)
    (suite,) = root.findall("testsuite[@name='TP1']")
    assert suite.get("tests") == str(len(Outcome))
    assert [suite.get(key) for key in ("failures", "errors", "skipped")] == ["3", "1", "2"]
    failure = suite.find("testcase/failure")
    assert failure is not None
    call = HOSTILE.replace("\x1b", "\ufffd")
    said = f"{call} renvoie 1 ; on attend 2."
    assert failure.get("message") == said


def test_hints_come_by_their_level() -> None:
    """A question, then a hint, then the most direct one."""
    name = RULES.exercises[0].checks[0].id
    finding = Finding(name, "title", Outcome.FAILED)
    for language in LANGUAGES:
        texts = Texts(language)
        (hints,) = {tuple(grade([finding], RULES, texts, hint=k)[0][0].hint for k in (1, 2, 3))}
        assert hints == (
            texts.say(f"question.{name}"),
            texts.say(f"hint.{name}.2"),
            texts.say(f"hint.{name}.3"),
        )


def test_what_a_broken_file_keeps_waiting_says_so() -> None:
    """It is not the exercise that must be written, it is the file that must compile."""
    check = "tp4.octree.hits"
    finding = Finding(check, "title", Outcome.FAILED, todo=frozenset({"TP2.4"}))
    for rejected, note in (
        ((), "Il manque peut-être encore TP2.4 ; voici, en attendant, ce que l'on observe."),
        (("raytracer.c",), "À juger quand raytracer.c compilera."),
    ):
        ((result,), _) = grade([finding], RULES, Texts("fr"), rejected=rejected)
        assert (result.outcome, result.note) == (Outcome.BLOCKED, note)


def test_the_more_direct_hints_come_along() -> None:
    """Those beyond the level that was asked for, of a check that may have a question at all."""
    check = RULES.exercises[0].checks[0].id
    finding = Finding(check, "title", Outcome.FAILED, Message("failure.twin"))
    texts = Texts("fr")
    for level, levels in ((1, [2, 3]), (2, [3]), (3, [])):
        ((result,), _) = grade([finding], RULES, texts, hint=level)
        assert [*result.hints] == levels
        assert all(result.hints[k] == texts.get(f"hint.{check}.{k}") for k in levels)
    passed = Finding(check, "title", Outcome.PASSED)
    ((result,), _) = grade([passed], RULES, texts)
    assert result.hints == {}


def test_a_check_names_the_function_that_it_calls() -> None:
    """Of an exercise of several, not always the first: that of its suite of inputs."""
    for check in RULES.checks().values():
        suite = exercises.EXPECTED / f"{check.id.partition('.')[2]}.npz"
        if suite.exists():
            arrays = expected_data.arrays_of(suite, expected_data.rules_of(suite))
            called = str(arrays["0.function"])
            if called in RULES.exercise(check.exercise).functions:
                assert check.function == called, check.id


def test_a_death_while_loading_has_no_call_to_name() -> None:
    """A constructor that crashes is told as such."""
    message = Message("death.SIGSEGV", {"call": ""})
    check = RULES.exercises[0].checks[0].id
    finding = Finding(check, "title", Outcome.CRASHED, message)
    ((result,), _) = grade([finding], RULES, Texts("fr"))
    assert result.message.startswith("Votre code, dès son chargement, lit ou écrit hors")


def test_a_function_that_was_not_judged_gets_no_question() -> None:
    """What its check asks would lead astray."""
    check = RULES.exercises[0].checks[0].id
    finding = Finding(check, "title", Outcome.FAILED, Message("failure.missing", {"name": "f"}))
    ((result,), _) = grade([finding], RULES, Texts("fr"))
    assert result.hint == ""


@pytest.fixture
def run(
    cache: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> Callable[..., tuple[int, dict[str, Any], str]]:
    """Return a function that grades one exercise of a folder, with further options (-k: others)."""

    def grade(folder: Path, *words: str) -> tuple[int, dict[str, Any], str]:
        build = outputs(tmp_path / "build", cache)
        arguments = ["grade", str(folder), "--build", str(build), "-k", "fill_red", *words]
        code = commands.main([*arguments, "--lang", "en"])
        path = build / "grade" / "partial" / "results.json"
        content = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
        captured = capsys.readouterr()
        return code, content, captured.out + captured.err

    return grade


def test_a_run_writes_its_three_results(
    run: Callable[..., tuple[int, dict[str, Any], str]], submission: Write, tmp_path: Path
) -> None:
    """results.json as the schema says, junit.xml beside it, and an exit code for a low mark."""
    folder = submission()
    code, content, _ = run(folder, "--fail-under", "2")
    assert (code, content["score"], list(schema.faults(content))) == (ExitCode.DONE, 2, [])
    assert (tmp_path / "build" / "grade" / "partial" / "junit.xml").exists()
    assert run(folder, "--fail-under", "2.5")[0] == ExitCode.BELOW


def test_an_archive_is_graded_as_its_folder_is(
    run: Callable[..., tuple[int, dict[str, Any], str]], submission: Write, tmp_path: Path
) -> None:
    """Same points; the report says where in the archive each file is."""
    path = Path(shutil.make_archive(str(tmp_path / "archive"), "gztar", submission()))
    code, content, said = run(path)
    assert (code, content["score"], content["submission"]["name"]) == (
        ExitCode.DONE,
        2,
        "archive",
    )
    assert f"{path} : main.c" in said


def test_a_level_of_isolation_can_be_asked_for(
    run: Callable[..., tuple[int, dict[str, Any], str]], submission: Write
) -> None:
    """The report says which one it was."""
    code, content, said = run(submission(), "--isolation", "portable")
    assert (code, content["isolation"]) == (ExitCode.DONE, "portable")
    assert 'level "portable"' in said


def test_a_folder_without_expected_data_is_wrong_use(
    run: Callable[..., tuple[int, dict[str, Any], str]], submission: Write, tmp_path: Path
) -> None:
    """One line, before anything is run."""
    code, content, said = run(submission(), "--expected", str(tmp_path))
    assert (code, content) == (ExitCode.WRONG_USE, {})
    assert said.startswith(f"{tmp_path / 'manifest.json'}: this file of expected data cannot be")
    assert said.count("\n") == 1


def test_a_damaged_file_of_expected_data_is_told_by_its_name(
    run: Callable[..., tuple[int, dict[str, Any], str]], submission: Write, tmp_path: Path
) -> None:
    """And by the cure: never as a zero, nor with a path of this machine."""
    copy = Path(shutil.copytree(exercises.EXPECTED, tmp_path / "expected"))
    (copy / "camera_ray.anywhere.npz").write_bytes(b"odd")
    words = ("--expected", str(copy), "-k", "camera_ray.anywhere")
    code, content, _ = run(submission(), *words)
    assert (code, content["incomplete"]) == (ExitCode.FAILED, True)
    (check,) = (each for each in content["checks"] if each["outcome"] == "error")
    assert check["message"].startswith("This check could not be made: the file camera_ray.anywhere")
    assert "put the original folder back, reference/expected." in check["message"]
    assert check["hint"] == ""
    assert str(tmp_path) not in check["message"]


def test_the_course_can_be_set_up(tmp_path: Path) -> None:
    """Language, dialect, opened TPs; anything else is told by its name."""
    path = tmp_path / "course.toml"
    path.write_text('language = "en"\ndialect = "c++"\nopened = [2, 1]\n', encoding="utf-8")
    assert settings.load(path) == settings.Course("en", "c++", (1, 2), count_closed=False)
    assert settings.load().opened == tuple(RULES.tps)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('language = "de"\n', "language must be one of fr, en"),
        ('language = "fr"\ndialect = "c"\nopened = [9]\n', "opened must be a list of TPs"),
        ('language = "fr"\ndialect = "c"\nopened = 1\n', "opened must be a list of TPs"),
        ('language = "fr"\ndialect = "c"\nopened = []\ncolour = 1\n', "colour is unknown here"),
    ],
)
def test_wrong_settings_are_named(tmp_path: Path, text: str, words: str) -> None:
    """One line with the file and what is wrong with it."""
    path = tmp_path / "course.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ManifestError, match=rf"course\.toml, line \d: {words}"):
        settings.load(path)


def test_darwin_has_its_own_flags_for_linking_and_cxx() -> None:
    """GNU ld's never reach its linker."""
    darwin, linux = (Compiler(("clang",), "clang", each) for each in ("darwin", "linux"))
    assert toolchain.strict_link_flags(darwin) == toolchain.lenient_link_flags(darwin) == []
    assert toolchain.cxx_library(darwin) == "-lc++"
    assert toolchain.strict_link_flags(linux) == ["-Wl,--require-defined=main"]
    assert "-std=gnu++17" in toolchain.compile_flags(linux, Target(96, 64), "c++")


def test_pictures_of_an_earlier_run_are_removed(tmp_path: Path) -> None:
    """Those that the new results do not name; what else stands in the folder is left alone."""
    content = every_outcome(folder=tmp_path)
    named = {name for each in content["checks"] for name in each["images"].values()}
    others = ["images/tp9.scene.mine.png", "images/notes.txt", "images/my-picture.png", "x.png"]
    for name in ("images/tp4.scene.mirror_0-detail.png", *others):
        (tmp_path / name).write_bytes(PNG)
    every_outcome(folder=tmp_path)
    left = {path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*.*")}
    assert left == named | set(others)


def test_totals_are_those_of_the_manifest() -> None:
    """100 points, and 20 of bonuses: said nowhere else."""
    rules = exercises.load()
    assert (rules.total(bonus=False), rules.total(bonus=True)) == (100, 20)
