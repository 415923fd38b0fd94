"""Recognising known mistakes: which are named, when nothing is, and what a student is told."""

from __future__ import annotations

import hashlib
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from grader.authoring.expected import mistake_bank
from grader.authoring.specimens import mistakes, patches, variants
from grader.authoring.specimens.grading import exercise_findings, graded
from grader.checking import observations
from grader.checking.expected_data import FOLDER, ExpectedError
from grader.checking.observations import Observation
from grader.checking.records import Evidence
from grader.course import exercises
from grader.course.message import Message
from grader.course.texts import Texts
from grader.evaluation import recognition
from grader.evaluation.grading import grade
from grader.evaluation.recognition import (
    BANK,
    KnownMistake,
    encode,
    read,
    recognised,
    signature,
    with_mistakes,
)
from grader.evaluation.records import Finding, Outcome

RULES = exercises.load()
KNOWN = {each.id: each for each in mistakes.load()}
DISTANCE, MEETS = "tp2.intersect_sphere.distance", "tp2.intersect_sphere.meets"
NEAREST = "tp2.intersect_scene.nearest"


def part(*values: float, cases: tuple[int, ...] = (0, 2), tolerance: float = 0.0) -> Observation:
    """Return the wrong cases of a part, one number each."""
    column = np.array(values, np.float32)[:, None]
    return Observation(np.array(cases), column, tolerance)


def finding(check: str, *parts: Observation, **fields: object) -> Finding:
    """Return a check that failed on these parts, or passed without any."""
    outcome = Outcome.FAILED if parts else Outcome.PASSED
    message = Message("failure.output") if parts else None
    wrong = {str(number): each for number, each in enumerate(parts)}
    made = Finding(check, "title", outcome, message, observations=wrong)
    return replace(made, **fields)  # type: ignore[arg-type]


def known(*findings: Finding) -> KnownMistake:
    """Return a mistake that gives these findings."""
    exercise = RULES.checks()[findings[0].check].exercise
    return KnownMistake(exercise, signature(findings))


# ---- The answers that agree ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("one", "other", "expected"),
    [
        (part(1, 2), part(1, 2), True),
        (part(1, 2, tolerance=0.1), part(1.05, 2.1), True),
        (part(1, 2, tolerance=0.1), part(1, 2.3), False),
        (part(1, 2, tolerance=0.1), part(1, 2, cases=(0, 3)), False),
        (part(1, 2), part(1, cases=(0,)), False),
        (part(np.nan, np.inf), part(np.nan, np.inf), True),
        (part(np.nan, 1, tolerance=0.1), part(1, 1), False),
        (part(np.inf, 1, tolerance=0.1), part(1, 1), False),
        (part(1, 1, tolerance=0.1), part(np.inf, 1), False),
    ],
)
def test_answers_agree_within_the_tolerance(
    one: Observation, other: Observation, expected: bool
) -> None:
    """Same cases, same values relative to those above 1; a NaN is like a NaN only."""
    assert one.agrees(other) is expected


def test_only_what_is_wrong_is_put_down() -> None:
    """The cases that are wrong with their values; nothing of parts that are right."""
    found = observations.Observations()
    got = np.arange(6, dtype=np.float64).reshape(3, 2)
    found.note("right", got, np.zeros(3, bool))
    found.note("wrong", got, np.array([True, False, True]), 0.5)
    found.note_mask("pixels", np.zeros((2, 2), bool))
    (name,) = found.parts
    assert name == "wrong"
    assert found.parts[name].cases.tolist() == [0, 2]
    assert found.parts[name].values.tolist() == [[0, 1], [4, 5]]


# ---- When something is named --------------------------------------------------------------------

FAR = (finding(DISTANCE, part(6, 7)), finding(MEETS))


@pytest.mark.parametrize(
    ("findings", "expected"),
    [
        (FAR, ("far",)),
        # One more check fails than the mistake explains.
        ((FAR[0], finding(MEETS, part(1, 1))), ()),
        # Not all of the checks were run.
        ((FAR[0],), ("far",)),
        # Other answers, other cases, another complaint.
        ((finding(DISTANCE, part(6, 8)),), ()),
        ((finding(DISTANCE, part(6, 7, cases=(0, 1))),), ()),
        ((replace(FAR[0], message=Message("failure.not_written")),), ()),
        # To do, or not judged.
        ((replace(FAR[0], outcome=Outcome.TODO),), ()),
        ((FAR[0], replace(FAR[1], outcome=Outcome.ERROR)), ()),
    ],
)
def test_a_mistake_explains_all_or_nothing(
    findings: tuple[Finding, ...], expected: tuple[str, ...]
) -> None:
    """It is named when every answer that is wrong is the one that it gives."""
    assert recognised(findings, {"far": known(*FAR)}) == expected


def test_mistakes_that_are_alike_are_named_together() -> None:
    """Three at most: more would be guessing."""
    one = known(*FAR)
    for count, expected in ((2, ("m0", "m1")), (3, ("m0", "m1", "m2")), (4, ())):
        assert recognised(FAR, {f"m{k}": one for k in range(count)}) == expected


def with_bank(folder: Path, content: dict[str, KnownMistake]) -> Path:
    """Return a folder of expected data that has nothing but a bank."""
    (folder / BANK).write_bytes(encode(content))
    digest = hashlib.sha256((folder / BANK).read_bytes()).hexdigest()
    text = f'{{"files": {{}}, "bank": {{"sha256": "{digest}"}}}}'
    (folder / "manifest.json").write_text(text, encoding="utf-8")
    return folder


def test_what_depends_on_a_wrong_exercise_is_not_named(tmp_path: Path) -> None:
    """Unless it is wrong by itself; the wrong exercise is."""
    nearest = finding(NEAREST, part(3, 4))
    folder = with_bank(tmp_path, {"far": known(FAR[0]), "first": known(nearest)})

    def ids(*findings: Finding) -> list[tuple[str, ...]]:
        return [each.evidence.mistakes for each in with_mistakes(findings, RULES, folder)]

    assert ids(FAR[1], nearest) == [(), ("first",)]
    assert ids(FAR[0], nearest) == [("far",), ()]
    assert ids(FAR[0], replace(nearest, alone=True)) == [("far",), ("first",)]


def test_a_picture_names_nothing_that_the_function_denies(tmp_path: Path) -> None:
    """What is drawn may look like a mistake's, and the function answer otherwise."""
    leaving = finding("tp5.refracted_ray.leaving", part(6, 7))
    folder = with_bank(tmp_path, {"turned": known(leaving)})
    drawn = finding("tp5.scene.glass_7", part(1), candidates=("turned",))

    def ids(*findings: Finding) -> list[tuple[str, ...]]:
        return [each.evidence.mistakes for each in with_mistakes(findings, RULES, folder)]

    assert ids(leaving, drawn) == [("turned",), ("turned",)]
    entering = finding("tp5.refracted_ray.entering", part(6, 7))
    assert ids(entering, leaving, drawn) == [(), (), ()]
    assert ids(drawn) == [("turned",)]


def test_a_bank_comes_back_as_it_was_written(tmp_path: Path) -> None:
    """Cases, values and names; the same bytes for the same mistakes."""
    content = {"far": known(*FAR), "other": known(finding(NEAREST, part(1, 2, 3, cases=(1, 2, 5))))}
    (back_far, back_other) = read(with_bank(tmp_path, content)).values()
    assert recognition.same(content["far"].signature, back_far.signature)
    assert recognition.same(content["other"].signature, back_other.signature)
    assert encode(content) == encode(dict(content))


def test_a_folder_without_a_bank_names_nothing(tmp_path: Path) -> None:
    """Another seed's data may have been made without it."""
    (tmp_path / "manifest.json").write_text('{"files": {}}', encoding="utf-8")
    assert with_mistakes(FAR, RULES, tmp_path) == list(FAR)


def test_a_damaged_bank_is_named(tmp_path: Path) -> None:
    """The file and the cure."""
    folder = with_bank(tmp_path, {"far": known(*FAR)})
    (folder / BANK).write_bytes(b"odd")
    with pytest.raises(ExpectedError, match=rf"{BANK}: .*; put the original folder back"):
        with_mistakes(FAR, RULES, folder)


def test_the_bank_is_of_today(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Made from today's mistakes and suites, which a changed manifest would not be."""
    assert mistake_bank.main(["--check"]) == 0
    folder = tmp_path / "données"
    shutil.copytree(FOLDER, folder, ignore=shutil.ignore_patterns("pictures"))
    text = (folder / "manifest.json").read_text(encoding="utf-8")
    (folder / "manifest.json").write_text(text.replace("reflectance.any", "x"), encoding="utf-8")
    assert mistake_bank.main(["--check", "--out", str(folder)]) == 1
    assert f"{BANK} was made from other mistakes or suites" in capsys.readouterr().out


# ---- Whole grades -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name", ["rect_not_clipped", "sphere_far_root", "shade_h_not_unit", "raytrace_upside_down"]
)
def test_a_known_mistake_is_named(name: str, cache: Path) -> None:
    """On the checks of its exercise that fail, and on no other exercise."""
    mistake = KNOWN[name]
    checks = graded(mistake.submission(), cache, mistake.tp)
    told = {each.id: each.mistakes for each in checks if each.mistakes}
    assert set(told) >= set(mistake.shows)
    assert set(told.values()) == {(name,)}
    assert {RULES.checks()[each].exercise for each in told} == {mistake.exercise}


def test_a_mistake_is_named_in_other_arithmetic(cache: Path) -> None:
    """The answers agree within the tolerance of the check, not to the bit."""
    files = {each.id: each for each in variants.load()}["shade_double"].files()
    wrong = files["raytracer.c"].replace("vector_float_mul(1.f / PI, mat->kd)", "mat->kd")
    submission = patches.submission("double", {**files, "raytracer.c": wrong})
    findings = exercise_findings(submission, "TP3.1", cache)
    assert {each.evidence.mistakes for each in findings if each.outcome is Outcome.FAILED} == {
        ("shade_pi_forgotten",)
    }


def test_two_mistakes_at_once_are_not_guessed(cache: Path) -> None:
    """In one function, their answers are those of neither."""
    both = KNOWN["shade_h_not_unit"].files(KNOWN["shade_pi_forgotten"].files())
    findings = exercise_findings(patches.submission("both", both), "TP3.1", cache)
    assert any(each.outcome is Outcome.FAILED for each in findings)
    assert {each.evidence.mistakes for each in findings} == {()}


# ---- What is told -------------------------------------------------------------------------------


def told(hint: int, *names: str, language: str = "fr") -> str:
    """Return the help given at a level for a check in which mistakes are recognised."""
    message, evidence = Message("failure.twin"), Evidence(mistakes=names)
    wrong = finding(DISTANCE, part(6, 7), message=message, evidence=evidence)
    ((result,), _) = grade([wrong], RULES, Texts(language), hint)
    assert result.mistakes == names
    return result.hint


def test_a_mistake_is_named_on_the_third_request() -> None:
    """First its question, then its hint, then its name with the hint."""
    say = Texts("fr").say
    title, question, text = (
        say(f"mistake.sphere_far_root.{each}") for each in ("title", "question", "hint")
    )
    assert [told(level, "sphere_far_root") for level in (1, 2, 3)] == [
        question,
        text,
        f"{title} {text}",
    ]


def test_twins_are_told_together() -> None:
    """Each sentence once."""
    names = ("sphere_tmin_ignored", "sphere_far_root")
    say = Texts("en").say
    questions = [say(f"mistake.{name}.question") for name in names]
    assert told(1, *names, language="en") == " Or: ".join(questions)
    assert told(1, "circle_row_length", "rect_row_length") == told(1, "rect_row_length")


def test_an_unknown_mistake_leaves_the_question_of_the_check() -> None:
    """A bank may know one that the messages do not know yet."""
    assert told(1, "of_tomorrow") == Texts("fr").say(f"question.{DISTANCE}")
