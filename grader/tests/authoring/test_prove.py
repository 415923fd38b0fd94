"""`make prove`: what each part counts and finds, how a run goes on, and the README's table."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from grader.authoring.proof import (
    __main__,
    cases,
    changes,
    contracts,
    figures,
    flaky,
    fresh,
    grades,
    half_written,
    known,
    load,
    nothing,
    page,
    pairs,
    right,
    slips,
    solver,
)
from grader.authoring.proof.figures import KEYS, FiguresError
from grader.authoring.proof.flaky import RepeatedRuns, Series
from grader.authoring.proof.grades import Grade, GradeCache, Program, ProofError
from grader.authoring.proof.mutants import FunctionScore, MutantsReport, Verdict
from grader.authoring.proof.parts import Part, sampled
from grader.authoring.specimens import mistakes, variants
from grader.authoring.specimens.contracts import Contracts
from grader.course import exercises
from grader.tests.support.outputs import outputs

RULES = exercises.load()
KNOWN = {each.id: each for each in mistakes.load()}
FAR = KNOWN["sphere_far_root"]
PI = KNOWN["shade_pi_forgotten"]


def grade(named: Mapping[str, tuple[str, ...]] | None = None, **lost: float) -> Grade:
    """Return what a program got that lost points in exercises: TP2_4=2.5; checks name mistakes."""
    points = {each.id: each.points / 100 for each in RULES.exercises}
    rows = [
        {"id": name, "points": most - lost.get(name.replace(".", "_"), 0), "max_points": most}
        for name, most in points.items()
    ]
    checks = [
        {
            "id": name,
            "exercise": check.exercise,
            "outcome": "failed",
            "message": "…",
            "points": 0,
            "max_points": check.points / 100,
            "mistakes": list((named or {}).get(name, ())),
        }
        for name, check in RULES.checks().items()
        if lost.get(check.exercise.replace(".", "_"))
    ]
    total = sum(row["points"] for row in rows if isinstance(row["points"], float))
    content = {"score": total, "bonus": 0.0, "exercises": rows, "checks": checks}
    return Grade({**content, "build": {"ok": True}})


# ---- Known mistakes and pairs -------------------------------------------------------------------


def test_a_mistake_is_caught_in_its_own_exercise_and_nowhere_else() -> None:
    """Four ways of being judged: as it should be, unseen, elsewhere too, and by a wrong name."""
    here, wrong = (
        {"tp2.intersect_sphere.distance": (FAR.id,)},
        {"tp2.intersect_sphere.miss": (PI.id,)},
    )
    found = [
        (FAR, grade(here, TP2_4=1)),
        (FAR, grade()),
        (FAR, grade(here, TP2_4=1, TP2_5=1)),
        (FAR, grade({**here, **wrong}, TP2_4=1)),
    ]
    part = known.report(found)
    assert part.figures == {
        "known_mistakes": 4,
        "caught": 3,
        "elsewhere": 1,
        "named_right": 2,
        "named_wrong": 1,
        "named_none": 1,
    }
    assert part.faults == [
        "sphere_far_root: loses nothing in TP2.4",
        "sphere_far_root (TP2.4): loses in TP2.5 too",
        "sphere_far_root: named shade_pi_forgotten, sphere_far_root",
    ]


def test_a_twin_is_named_with_a_mistake_never_without() -> None:
    """What no check tells apart is named together."""
    one = next(each for each in KNOWN.values() if each.twins)
    check = RULES.exercise(one.exercise).checks[0].id
    lost = {one.exercise.replace(".", "_"): 1.0}
    assert known.naming(one, grade({check: (one.id, *one.twins)}, **lost)) == known.RIGHT
    assert known.naming(one, grade({check: one.twins}, **lost)) == known.WRONG


def test_pairs_are_drawn_from_different_exercises_always_the_same() -> None:
    """A hundred of them; both changes are in the files."""
    drawn = pairs.drawn(pairs.PAIRS)
    assert [each.id for each in drawn] == [each.id for each in pairs.drawn(pairs.PAIRS)]
    assert len({each.id for each in drawn}) == pairs.PAIRS == 100
    for each in drawn:
        assert each.one.exercise != each.other.exercise
        assert each.files not in (each.one.files(), each.other.files())


def test_what_a_pair_must_do() -> None:
    """Both lose points, no third is named, and mending one never lowers an exercise."""
    pair = pairs.Pair(FAR, PI, {})
    check = "tp2.intersect_sphere.miss"
    good = {
        pair.id: grade({check: (FAR.id,)}, TP2_4=2, TP3_1=3),
        FAR.id: grade(TP2_4=2),
        PI.id: grade(TP3_1=3),
    }
    bad = {
        pair.id: grade({check: ("plane_sign",)}, TP2_4=2),
        FAR.id: grade(TP2_4=2.5),
        PI.id: grade(TP3_1=3),
    }
    assert pairs.report([pair], good).faults == []
    part = pairs.report([pair], bad)
    assert part.faults == [
        f"{pair.id}: shade_pi_forgotten loses nothing in TP3.1",
        f"{pair.id}: {check} names plane_sign",
        f"{pair.id}: mending sphere_far_root costs points in TP3.1",
        f"{pair.id}: mending shade_pi_forgotten costs points in TP2.4",
    ]
    assert part.figures["mendings_lowered"] == 2


# ---- What is right, and what is no work ---------------------------------------------------------


def test_every_variant_is_built_by_both_compilers() -> None:
    """But those that are about a compiler."""
    builds = {each.id: [p.compiler for p in right.programs(each)] for each in variants.load()}
    assert builds["sphere_double"] == ["gcc", "clang"]
    assert builds["clang"] == ["clang"]
    flags = {flag for each in variants.load() for flag in each.flags}
    assert {"-O0", "-O1", "-O3"} <= flags


def test_a_variant_that_loses_points_is_told() -> None:
    """By its build and the check; of one apart, what it never calls may be to do."""
    variant = variants.load()[0]
    part = right.report([(variant, "one", grade()), (variant, "two", grade(TP4_2=6))])
    assert (part.figures["variants"], part.figures["variants_full"]) == (1, 0)
    assert part.figures["variant_builds_full"] == 1
    assert part.faults[0] == "two: tp4.reflected_ray.direction (failed): …"
    todo = grade(TP4_2=6)
    for each in todo.content["checks"]:
        each["outcome"] = "todo"
    assert right.report([(replace(variant, apart=True), "two", todo)]).faults == []
    assert right.report([(variant, "two", todo)]).faults


def test_other_inputs_make_another_grade(tmp_path: Path) -> None:
    """What is kept of a program is of its inputs too; one that loses points on them is told."""
    variant = variants.load()[0]
    own = Program(variant.id, variant.files())
    with pytest.raises(ProofError, match=r"manifest\.json: No such file"):
        _ = replace(own, inputs=tmp_path).key
    (tmp_path / "manifest.json").write_text("{}", encoding="utf-8")
    assert replace(own, inputs=tmp_path).key != own.key
    part = fresh.report([(variant, "11", grade()), (variant, "12", grade(TP4_2=6))])
    assert part.figures == {"fresh": 2, "fresh_full": 1}
    assert part.faults[0] == f"{variant.id}: tp4.reflected_ray.direction (failed): …"


def test_the_solver_tries_something_for_every_function() -> None:
    """But where a constant is the answer, and in the student's own drawing."""
    names = {name for each in RULES.exercises for name in each.functions}
    assert names - set(solver.ATTEMPTS) == {"fill_red", "fill", "draw"}
    text = solver.files(0)["main.c"]
    assert 'MRT_TODO("TP1.4")' not in text
    assert 'MRT_TODO("TP1.2")' in text


def test_no_work_that_earns_points_is_told() -> None:
    """And a check of the skeleton that is anything else than to do."""
    quiet = grade(TP4_2=6)
    for each in quiet.content["checks"]:
        each["outcome"] = "todo"
    earning = grade(TP4_2=6)
    earning.content["checks"][0]["points"] = 1
    assert nothing.report({nothing.SKELETON: quiet, "attempt 1": quiet}).faults == []
    assert nothing.report({nothing.SKELETON: quiet, "attempt 1": earning}).faults == [
        "attempt 1: earns tp4.reflected_ray.direction"
    ]
    assert nothing.report({nothing.SKELETON: grade(TP4_2=6)}).faults == [
        "skeleton: a check is failed"
    ]


# ---- The same results ---------------------------------------------------------------------------


class Turns(GradeCache):
    """A shop whose programs give something else from time to time."""

    def each(self, programs: Any, builds: Path) -> Any:
        """Give every third time something else."""
        for program in programs:
            count = self.folder / "count"
            turn = int(count.read_text()) if count.exists() else 0
            count.write_text(str(turn + 1))
            yield program, {"checks": [{"points": 1, "message": "late" if turn % 3 == 2 else ""}]}


def test_a_run_that_differs_is_told_and_where(tmp_path: Path) -> None:
    """What was run already is not run again; more runs go on from there."""
    series = Series(Program("odd", {"main.c": ""}), 6)
    grade_cache = Turns(tmp_path)
    first = flaky.repeated(grade_cache, series, 4)
    assert first == RepeatedRuns(4, 1, [".checks[0].message: '' or 'late'"])
    assert flaky.repeated(grade_cache, series, 4) == first
    assert flaky.repeated(grade_cache, series, 6) == replace(first, runs=6, others=2)
    part = flaky.report([(series, first)])
    assert part.figures == {"runs": 4, "flaky": 1}
    assert part.faults == ["odd: 1 of 4 runs differ: .checks[0].message: '' or 'late'"]


def test_the_series_are_what_the_proof_promises() -> None:
    """The reference two hundred times, ten that fail and a busy machine twenty times."""
    quiet = [each for each in flaky.all_series() if not each.busy]
    assert [each.count for each in quiet if each.program.id == "reference"] == [200]
    others = {each.program.key: each.count for each in quiet if each.program.id != "reference"}
    assert list(others.values()) == [20] * 10
    assert [each.count for each in flaky.all_series() if each.busy] == [20, 20]


def test_differences_name_their_place() -> None:
    """In objects and in lists, and what only one of the two has."""
    assert flaky.differences({"a": [1, 2], "b": 0}, {"a": [1, 3, 4]}) == [
        ".a[1]: 2 or 3",
        ".a[2]: None or 4",
        ".b: 0 or None",
    ]


def test_a_busy_machine_is_left_as_it_was() -> None:
    """As many processes as were asked for, none of which is there afterwards."""
    with load.busy(2) as started:
        assert len(started) == 2
        for each in started:
            os.kill(each, 0)
    for each in started:
        with pytest.raises(ProcessLookupError):
            os.kill(each, 0)


# ---- Mutants ------------------------------------------------------------------------------------


def mutants_report(caught: int, survivors: int, reason: str = "") -> MutantsReport:
    """Return the report of a function of which some changes are caught."""
    left = Verdict("raytracer.c", "shade", 7, "sign", "a +\n b", "a - b", "")
    total = caught + survivors + 1
    return MutantsReport(
        total,
        1,
        caught,
        (left,) * survivors,
        (FunctionScore("shade", "raytracer.c", total, 1, caught),),
        (replace(left, same=not reason, reason=reason),),
    )


def test_mutants_that_are_not_caught_are_told() -> None:
    """With their line, and the scores that are too low."""
    assert changes.report(mutants_report(99, 0)).faults == []
    part = changes.report(mutants_report(18, 2))
    assert part.figures["mutation_score"] == part.figures["mutation_score_worst_function"] == 0.9
    assert part.faults == [
        "90.0% caught, below 98%",
        "shade: 90.0% caught",
        *["not caught: raytracer.c:7 shade: a + b → a - b"] * 2,
    ]


def test_few_mutants_are_equivalent_by_a_sentence() -> None:
    """Two in a hundred."""
    assert changes.report(mutants_report(99, 0, reason="x")).faults == []
    faults = changes.report(mutants_report(9, 0, reason="x")).faults
    assert faults == ["1 mutants are called equivalent without a proof"]


# ---- Figures, page and table --------------------------------------------------------------------


def some_part(**values: float) -> Part:
    """Return a part with these figures."""
    return Part("known", "Known mistakes", values, ["a <fault>"], ["mistake"], [["far & wide"]])


def test_results_have_exactly_their_keys(tmp_path: Path) -> None:
    """What was not measured is null; other figures stand on the page only."""
    __main__.publish([some_part(known_mistakes=3, elsewhere=1)], tmp_path)
    content = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    assert tuple(content) == KEYS
    assert (content["known_mistakes"], content["flaky"]) == (3, None)
    text = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert "a &lt;fault&gt;" in text
    assert "far &amp; wide" in text
    assert "Not measured yet" in text
    assert page.NAMES["flaky"] in text


def test_every_figure_has_a_name() -> None:
    """What a part counts can be told on the page."""
    assert set(KEYS) <= set(page.NAMES)
    made = [
        known.report([]),
        half_written.report([]),
        pairs.report([], {}),
        right.report([]),
        fresh.report([]),
        flaky.report([]),
        nothing.report({nothing.SKELETON: grade()}),
        changes.report(mutants_report(9, 0)),
        cases.report([]),
        contracts.report(Contracts((), ()), {}),
        slips.report([]),
    ]
    assert {key for each in made for key in each.figures} == set(page.NAMES)


def test_the_table_of_the_readme_is_what_is_kept() -> None:
    """`make prove` writes it; nobody else."""
    text = figures.README.read_text(encoding="utf-8")
    assert figures.in_readme(text, figures.kept()) == text


def test_a_part_is_kept_beside_the_others(tmp_path: Path) -> None:
    """The table has a line for each part that was run whole."""
    path, readme = tmp_path / "proof.json", tmp_path / "README.md"
    readme.write_text(f"before\n{figures.BEGIN}\nold\n{figures.END}\nafter\n", encoding="utf-8")
    figures.keep({"variants": 56, "variants_full": 55}, path)
    figures.keep({"runs": 4, "flaky": 1}, path)
    figures.keep({"variants_full": 56}, path)
    figures.write_readme(readme, path)
    assert readme.read_text(encoding="utf-8").splitlines() == [
        "before",
        figures.BEGIN,
        "| what was tried | what came out |",
        "|---|---|",
        "| 56 right solutions written differently | 56 have every point |",
        "| 4 grades of the same submissions | 1 differ |",
        figures.END,
        "after",
    ]


def test_what_keeps_the_table_from_being_written_is_told(tmp_path: Path) -> None:
    """The file and the cure."""
    with pytest.raises(FiguresError, match=r"README\.md: put back its lines <!-- BEGIN PROOF"):
        figures.in_readme("no marks", {})
    with pytest.raises(FiguresError, match=r"proof\.json: .*; make it again: make prove"):
        figures.kept(tmp_path / "proof.json")


# ---- Grading, and the command -------------------------------------------------------------------


def test_a_sample_is_drawn_by_a_fixed_lot() -> None:
    """In the order of the whole."""
    items = list(range(50))
    chosen = sampled(items, 5)
    assert chosen == sampled(items, 5) == sorted(chosen)
    assert len(chosen) == 5
    assert sampled(items, None) == sampled(items, 60) == items


def test_a_key_changes_with_what_is_graded_and_how() -> None:
    """The name of a program does not count."""
    one = Program("one", {"main.c": "int a;"})
    assert one.key == replace(one, id="other").key
    others = [replace(one, files={"main.c": ""}), replace(one, flags=("-O0",))]
    others.append(replace(one, compiler="clang"))
    assert len({one.key, *(each.key for each in others)}) == 4


def test_a_machines_fault_is_no_grade(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is kept, and the command tells which check it was."""
    row = {"id": "tp1.x", "outcome": "error", "message": "no room"}
    monkeypatch.setattr(grades, "results", lambda *_, **__: {"incomplete": True, "checks": [row]})
    grade_cache = GradeCache(tmp_path)
    with pytest.raises(ProofError, match=r"^odd: tp1\.x: no room$"):
        list(grade_cache.graded([Program("odd", {})]))
    assert not list(tmp_path.rglob("*.json"))


def test_a_sample_is_shown_kept_and_goes_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A second run takes what is kept; what is not as it should be is the exit code."""
    monkeypatch.setattr(os, "nice", lambda _: 0)
    monkeypatch.setattr(
        grades, "results", lambda *_, **__: {**grade().content, "incomplete": False}
    )
    words = ["--build", str(tmp_path), "--part", "known", "--sample", "2", "--jobs", "1"]
    assert __main__.main(words) == 1
    assert "known_mistakes 2, caught 0, elsewhere 0, named_right 0" in capsys.readouterr().out
    monkeypatch.setattr(grades, "results", None)
    assert __main__.main(words) == 1
    assert capsys.readouterr().out.count("loses nothing in") == 2
    text = (tmp_path / "prove" / "sample" / "results.json").read_text(encoding="utf-8")
    assert json.loads(text)["known_mistakes"] == 2


@pytest.mark.long
def test_a_mistake_is_paid_for_once(cache: Path, tmp_path: Path) -> None:
    """A whole grade, on every TP and picture: shade is wrong, and used rightly by TP5.2."""
    grade_cache = GradeCache(outputs(tmp_path, cache))
    ((_, found),) = grade_cache.graded([known.program(PI)])
    assert known.report([(PI, found)]).faults == []
    assert known.naming(PI, found) == known.RIGHT
    assert found.losing == {"TP3.1"}
