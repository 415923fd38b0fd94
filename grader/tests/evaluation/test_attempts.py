"""What passes on the inputs of the archive must pass on others too, where there are any."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path

import pytest

from grader.authoring.expected import command
from grader.authoring.specimens import mistakes
from grader.checking import expected_data
from grader.course import exercises
from grader.course.sizes import sizes_for
from grader.course.texts import Texts
from grader.evaluation.pipeline import report_of, run_checks
from grader.evaluation.records import CheckResult, Outcome, Report
from grader.execution.libraries import Libraries
from grader.execution.session import open_core
from grader.intake.records import Submission
from grader.tests.support.judging import REFERENCE, solution

KNOWN = "reflectance_not_squared"
SUITE = "reflectance.any"
FRESNEL = ("tp5.reflectance.any", "tp5.fresnel_schlick.angle", "tp5.fresnel_schlick.normal")


@pytest.fixture(scope="module")
def fresh(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return inputs of another seed than the archive's."""
    folder = tmp_path_factory.mktemp("inputs") / "data"
    words = ["--seed", "8", "--out", str(folder), "--without-pictures", "--without-bank"]
    words.append("--without-views")
    assert command.main(words) == 0
    return folder


def by_heart(cache: Path) -> dict[str, str]:
    """Return the solution with a table of the archive's answers in the place of reflectance."""
    with open_core(REFERENCE, *expected_data.SIZE, cache=cache) as core:
        (batch,) = expected_data.read(exercises.EXPECTED, SUITE, core)
    answers = batch.answers[0].result
    assert answers is not None
    rows = [each.astype(float) for each in (batch.args["n1"], batch.args["n2"], answers)]
    lines = [
        f"if (n1 == {n1}f && n2 == {n2}f) return {known}f;"
        for n1, n2, known in zip(*rows, strict=True)
    ]
    files = solution()
    text = files["raytracer.c"]
    head, _, rest = text.partition("float reflectance(float n1, float n2) {")
    body, _, after = rest.partition("\n}\n")
    assert "ratio" in body
    made = "\n".join([*lines, "return 0.5f;"])
    return {
        **files,
        "raytracer.c": f"{head}float reflectance(float n1, float n2) {{\n{made}\n}}\n{after}",
    }


def judged(
    files: Mapping[str, str], chosen: Collection[str], cache: Path, fresh: Path | None
) -> Report:
    """Judge some checks as a class's are."""
    rules = exercises.load()
    content = {name: text.encode() for name, text in files.items()}
    with Libraries(Submission("r", content, missing=()), sizes_for(None), cache) as libraries:
        findings = run_checks(libraries, rules, None, chosen, fresh=fresh)
        return report_of(libraries, rules, findings, Texts("en"))


def check(report: Report, name: str) -> CheckResult:
    """Return one check of a report."""
    (found,) = (each for each in report.checks if each.id == name)
    return found


def test_answers_by_heart_earn_nothing_on_other_inputs(cache: Path, fresh: Path) -> None:
    """They have all the points on the archive's inputs; on others none, the exercise is named."""
    files = by_heart(cache)
    public = judged(files, FRESNEL, cache, None)
    assert {each.outcome for each in public.checks} == {Outcome.PASSED}
    assert public.learnt == ()
    report = judged(files, FRESNEL, cache, fresh)
    wrong = check(report, FRESNEL[0])
    assert (wrong.outcome, wrong.points) == (Outcome.FAILED, 0)
    assert "reflectance(" in wrong.message
    assert "Right on the inputs that were" in wrong.note
    assert wrong.mistakes == ()
    assert report.learnt == ("TP5.1",)
    # The other function of the exercise is right, and keeps its points.
    assert all(each.points == each.max_points for each in report.checks if each != wrong)


def test_a_right_program_passes_on_any_inputs(cache: Path, fresh: Path) -> None:
    """The solution has every point of the functions, and nothing is said."""
    chosen = [
        each.id
        for each in exercises.load().checks().values()
        if not each.is_picture and not each.id.startswith("tp1")
    ]
    report = judged(solution(), chosen, cache, fresh)
    assert [each.id for each in report.checks if each.points != each.max_points or each.note] == []
    assert report.learnt == ()


def test_what_is_wrong_on_the_archive_is_told_and_named_there(cache: Path, fresh: Path) -> None:
    """A student finds it again at home: the inputs are those of the archive."""
    (wrong,) = (each.files() for each in mistakes.load() if each.id == KNOWN)
    public, both = (judged(wrong, FRESNEL, cache, where) for where in (None, fresh))
    told = [(each.message, each.mistakes, each.note, each.points) for each in public.checks]
    assert told == [(each.message, each.mistakes, each.note, each.points) for each in both.checks]
    assert check(both, FRESNEL[0]).mistakes == (KNOWN,)
    assert both.learnt == ()
