"""Small changes of the reference: how they are made, judged and told from what changes nothing."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest

from grader.authoring.proof import mutants, mutants_changes
from grader.authoring.proof.mutants import Hint, Verdict
from grader.authoring.proof.mutants_changes import Mutant
from grader.authoring.proof.mutants_source import LEFT_OUT, owners
from grader.authoring.specimens import patches
from grader.course import exercises

# Of different kinds, in functions of different exercises; each is caught by a check of its own.
SAMPLE = (
    ("camera_ray", "y - half_height", "y + half_height"),
    ("intersect_sphere", "t < r->tmin", "t >= r->tmin"),
    ("shade", "n_l <= 0.f", "n_l > 0.f"),
    ("checker_color", "cube.y", "cube.z"),
    ("bounce", "in->depth + 1", "in->depth - 1"),
    ("box_overlaps_object", "obj->type == PLANE", "obj->type != PLANE"),
)


@pytest.fixture(scope="module")
def every() -> list[Mutant]:
    """Return all the mutants."""
    return list(mutants_changes.mutants())


@pytest.fixture(scope="module")
def builds(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder of builds, which the tests of this file share."""
    return tmp_path_factory.mktemp("mutants")


def find(every: list[Mutant], function: str, before: str, after: str) -> Mutant:
    """Return a mutant by what it changes."""
    wanted = (function, before, after)
    return next(each for each in every if (each.function, each.before, each.after) == wanted)


def test_there_are_mutants_of_every_function(every: list[Mutant]) -> None:
    """At least 500, of ten kinds, in every function that is judged; none stands twice."""
    judged = {name for each in exercises.load().exercises for name in each.functions}
    assert len(every) >= 500
    assert len(Counter(each.kind for each in every)) == 10
    assert {each.function for each in every} >= judged - LEFT_OUT
    assert len({each.id for each in every}) == len(every)


def test_a_mutant_changes_one_function_only(every: list[Mutant]) -> None:
    """What stands before and after the function is the reference's, letter by letter."""
    mutant = find(every, "camera_ray", "y - half_height", "y + half_height")
    text = patches.reference()["raytracer.c"]
    start = text.index("void camera_ray(")
    end = text.index("\n}", start)
    assert mutant.text.startswith(text[:start])
    assert mutant.text.endswith(text[end:])
    assert "(y + half_height) / half_height" in mutant.text


def test_a_helper_belongs_to_the_exercises_that_call_it() -> None:
    """Through other helpers as well, but not through the functions of other exercises."""
    assert owners("raytracer.c", "solve_distance") == ("TP2.4", "TP2.B1")
    assert owners("raytracer.c", "bounce") == ("TP4.2", "TP5.B1")
    assert owners("octree.c", "take") == ("TP4.B1",)
    assert owners("main.c", "pixel_of") == ("TP1.4", "TP1.5")
    assert owners("raytracer.c", "shade") == ("TP3.1", "TP5.2")


@pytest.mark.parametrize("change", SAMPLE, ids=lambda change: change[0])
def test_the_checks_catch_a_sample(
    change: tuple[str, str, str], every: list[Mutant], builds: Path
) -> None:
    """Each loses points in a check of an exercise that owns the function."""
    mutant = find(every, *change)
    (verdict,) = mutants.judge([mutant], [Hint()], builds)
    checks = exercises.load().checks()
    assert checks[verdict.caught_by].exercise in owners(mutant.file, mutant.function)
    assert not verdict.same


@pytest.mark.long
def test_what_changes_nothing_is_told(every: list[Mutant], builds: Path) -> None:
    """Of two equal numbers either is the smaller one; what does not compile spoils nothing."""
    other = find(every, "smaller", "a < b", "a >= b")
    broken = replace(other, written=other.written.replace("a >= b", "a >= nobody"))
    same = find(every, "smaller", "a < b", "a <= b")
    verdicts = mutants.judge([broken, same, other], [Hint()] * 3, builds)
    assert verdicts[0].caught_by == mutants.NOT_BUILT
    assert (verdicts[1].caught_by, verdicts[1].same) == ("", True)
    assert verdicts[2].caught_by.startswith("tp1.")
    assert [each.same for each in verdicts] == [False, True, False]


VERDICT = Verdict("a.c", "f", 1, "sign", "-a", "a", "")


def test_the_report_counts_what_compiles(monkeypatch: pytest.MonkeyPatch) -> None:
    """A proof and a written reason set a mutant aside; what is left is caught or survives."""
    key = ("a.c", "g", "b", "c")
    monkeypatch.setattr(mutants, "read_reasons", lambda: {key: "both are accepted"})
    found = [
        replace(VERDICT, caught_by="tp1.x"),
        replace(VERDICT, caught_by=mutants.NOT_BUILT),
        replace(VERDICT, same=True),
        replace(VERDICT, before="x"),
        replace(VERDICT, function="g", before="b", after="c"),
    ]
    report = mutants.report(found)
    assert (report.total, report.equivalent, report.caught) == (4, 2, 1)
    assert [each.before for each in report.survivors] == ["x"]
    assert report.score == 0.5
    assert {each.function: each.score for each in report.functions} == {"f": 0.5, "g": 1.0}
    assert report.worst.function == "f"


def test_every_reason_is_that_of_a_mutant(every: list[Mutant]) -> None:
    """A reason whose mutant is gone would hide nothing, and mislead; at most 2 % have one."""
    reasons = mutants.read_reasons()
    assert set(reasons) <= {(each.file, each.function, each.before, each.after) for each in every}
    assert len(reasons) <= len(every) / 50
    assert all(len(reason) > 20 for reason in reasons.values())


def test_a_malformed_reason_is_told(tmp_path: Path) -> None:
    """The file and what it lacks."""
    path = tmp_path / "equivalent.toml"
    path.write_text('[[equivalent]]\nfile = "main.c"\n')
    with pytest.raises(exercises.ManifestError, match=r"equivalent.toml: .*function"):
        mutants.read_reasons(path)


def test_a_run_goes_on(
    every: list[Mutant], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is known is not judged again, but for what was judged by other checks."""
    asked: list[tuple[str, Hint]] = []

    def judge(chosen: list[Mutant], hints: list[Hint], cache: Path) -> list[Verdict]:
        asked.extend((each.id, hint) for each, hint in zip(chosen, hints, strict=True))
        return [
            Verdict(
                each.file, each.function, each.line, each.kind, each.before, each.after, "tp1.x"
            )
            for each in chosen
        ]

    monkeypatch.setattr(mutants, "KEPT", tmp_path)
    monkeypatch.setattr(mutants, "judge", judge)
    chosen = every[:2]
    assert mutants.verdicts(chosen, 1) == mutants.verdicts(chosen, 1)
    assert asked == [(each.id, Hint()) for each in chosen]
    path = tmp_path / f"{chosen[0].id}.json"
    path.write_text(json.dumps({**json.loads(path.read_text()), "judged_by": "others"}))
    mutants.verdicts(chosen, 1)
    assert asked[2:] == [(chosen[0].id, Hint("tp1.x"))]
