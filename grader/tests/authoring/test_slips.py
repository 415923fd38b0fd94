"""Slips: mistakes that students may well make lose points in their own exercise."""

from __future__ import annotations

from pathlib import Path

import pytest

from grader.authoring.proof import slips as proof
from grader.authoring.proof.edits import caught
from grader.authoring.specimens import contracts, mistakes, slips
from grader.authoring.specimens.patches import PatchError
from grader.authoring.specimens.slips import Slip
from grader.course.exercises import ManifestError
from grader.course.exercises import load as rules
from grader.tests.support.sampling import sampled

ALL = slips.load()


def test_every_slip_applies() -> None:
    """Two hundred at least, in every exercise that is judged; each makes another program."""
    assert len(ALL) >= 200
    assert {each.exercise for each in ALL} == {one.id for one in rules().exercises if one.checks}
    programs = {program(each) for each in ALL}
    others = {program(each) for each in contracts.load().breaches}
    others |= {program(each) for each in mistakes.load()}
    assert len(programs - others) == len(ALL)
    assert all(each.thought for each in ALL)


def program(each: Slip | contracts.Breach | mistakes.Mistake) -> tuple[tuple[str, str], ...]:
    """Return what stands for a program: its files."""
    return tuple(sorted(each.files().items()))


FUNCTIONS = sorted({each.function for each in ALL})


@pytest.mark.parametrize("function", sampled(FUNCTIONS, ["mirror_color", "intersect_scene"]))
def test_a_slip_is_caught(function: str, tmp_path: Path) -> None:
    """By a check of its exercise."""
    chosen = [each for each in ALL if each.function == function]
    found = dict(caught(chosen, tmp_path))
    assert [name for name, check in found.items() if not check] == []
    assert found.keys() == {each.id for each in chosen}


def test_what_is_not_caught_is_told() -> None:
    """In the part of the proof."""
    part = proof.report([(ALL[0], ""), (ALL[1], "tp1.fill_red.color")], whole=False)
    assert part.faults == [f"{ALL[0].id}: not caught"]
    assert part.figures == {"slips": 2, "slips_caught": 1}
    assert [ALL[1].exercise, ALL[1].id, ALL[1].thought, "tp1.fill_red.color"] in part.rows


def test_a_malformed_table_is_named(tmp_path: Path) -> None:
    """One line with the file."""
    path = tmp_path / "slips.toml"
    path.write_text('["TP1.1".odd]\nfunction = "fill"\n', encoding="utf-8")
    with pytest.raises(ManifestError, match=r"slips\.toml: missing or malformed key: "):
        slips.load(path)


def test_an_error_names_the_table() -> None:
    """And the slip that does not fit."""
    odd = Slip("odd", "TP1.1", "fill_red", "nowhere", "", "a thought")
    with pytest.raises(PatchError, match=r"slips\.toml: odd: .* stands 0 times"):
        odd.files()
