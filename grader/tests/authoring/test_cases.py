"""Programs from outside: what they lose, where, and what they are told to be."""

from __future__ import annotations

from pathlib import Path

import pytest

from grader.authoring.proof import cases as proof
from grader.authoring.proof.grades import Grade, Program
from grader.authoring.specimens import cases, mistakes
from grader.authoring.specimens.cases import Case
from grader.course.exercises import ManifestError, load
from grader.tests.support.sampling import sampled

CASES = {each.id: each for each in cases.load()}
SAMPLE = [
    "g4_list_as_tree",
    "g7_constants",
    "lights_clamped_in_loop",
    "octree_of_ten_levels",
    "pi_3_14",
    "t4_light_specular_in_shadow",
    "t5_glass_no_incoming",
    "trace_magenta_when_shading",
]


def test_every_patch_has_an_entry() -> None:
    """And the other way round; what an entry names is there."""
    assert {path.stem for path in cases.FOLDER.glob("*.patch")} == CASES.keys()
    exercises = {each.id for each in load().exercises}
    known = {each.id for each in mistakes.load()}
    for each in CASES.values():
        assert each.loses.keys() <= exercises, each.id
        assert {*each.named} <= known, each.id
        assert each.about, each.id


@pytest.mark.parametrize("name", sampled(CASES, SAMPLE, ["lights_clamped_in_loop", "pi_3_14"]))
def test_a_program_from_outside_has_a_fair_mark(name: str, cache: Path) -> None:
    """It loses where it is wrong, what a teacher takes off, and is not told to be another one.

    Where the list says that this is not met yet, it still is not: whoever mends it is told.
    """
    program = Program(name, CASES[name].files())
    faults = proof.faults(CASES[name], Grade(program.results(cache)))
    assert bool(faults) == bool(CASES[name].unmet), faults


def grade(points: dict[str, float], *named: str) -> Grade:
    """Return a grade of two exercises of 4 points."""
    rows = [{"id": name, "points": each, "max_points": 4} for name, each in points.items()]
    checks = [{"id": "tp2.intersect_plane.meets", "mistakes": list(named)}]
    total = sum(points.values())
    return Grade({"exercises": rows, "checks": checks, "score": total, "bonus": 0})


def test_too_much_too_little_and_elsewhere_are_unfair() -> None:
    """And so is a name that is another's, or none where there is one."""
    case = Case("odd", "", {"TP2.3": (0.2, 0.5)}, ("plane_sign",))
    assert proof.faults(case, grade({"TP2.3": 3, "TP2.4": 4}, "plane_sign")) == []
    assert proof.faults(case, grade({"TP2.3": 1, "TP2.4": 3}, "plane_other")) == [
        "odd: loses 75% of TP2.3, where 20% to 50% is fair",
        "odd: loses 25% of TP2.4, where 0% to 0% is fair",
        "odd: named plane_other",
    ]
    assert proof.faults(case, grade({"TP2.3": 4, "TP2.4": 4})) == [
        "odd: loses 0% of TP2.3, where 20% to 50% is fair",
        "odd: not named plane_sign",
    ]


def test_the_proof_counts_who_is_judged_fairly() -> None:
    """And has a line for each of the others, and a row for each."""
    fair = Case("odd", "a sign", {"TP2.3": (0.2, 0.5)})
    unfair = Case("even", "a root", {"TP2.4": (0.2, 0.5)})
    points = {"TP2.3": 3.0, "TP2.4": 4.0}
    part = proof.report([(fair, grade(points)), (unfair, grade(points))])
    assert part.figures == {"cases": 2, "cases_fair": 1}
    assert part.faults == [
        "even: loses 25% of TP2.3, where 0% to 0% is fair",
        "even: loses 0% of TP2.4, where 20% to 50% is fair",
    ]
    assert part.rows == [
        ["odd", "a sign", "TP2.3 25%", "TP2.3 20% to 50%"],
        ["even", "a root", "TP2.3 25%", "TP2.4 20% to 50%"],
    ]


def test_no_work_earns_next_to_nothing() -> None:
    """Whatever it loses."""
    case = Case("empty", "", earns=6)
    assert proof.faults(case, grade({"TP2.3": 3, "TP2.4": 3})) == []
    lines = ["empty: earns 7, at most 6 for no work"]
    assert proof.faults(case, grade({"TP2.3": 3, "TP2.4": 4})) == lines


@pytest.mark.parametrize("share", ["[0.5, 0.2]", "[0.5, 1.2]", "[0.5]", "7"])
def test_a_share_is_a_range(share: str, tmp_path: Path) -> None:
    """From 0 to 1, the least first."""
    path = tmp_path / "cases.toml"
    path.write_text(f'[case.odd]\nabout = ""\nloses = {{ "TP1.1" = {share} }}\n', encoding="utf-8")
    with pytest.raises(ManifestError, match=r"cases\.toml: missing or malformed key: "):
        cases.load(path)
