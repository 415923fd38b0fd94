"""The contracts of exercises.h: every sentence has a program that breaks it, and is caught."""

from __future__ import annotations

from pathlib import Path

import pytest

from grader.authoring.proof import contracts as proof
from grader.authoring.proof.edits import caught
from grader.authoring.specimens import contracts, variants
from grader.authoring.specimens.contracts import Breach
from grader.authoring.specimens.patches import PatchError
from grader.course.exercises import ManifestError
from grader.course.exercises import load as rules
from grader.tests.support.sampling import sampled

TABLE = contracts.load()


def test_every_sentence_has_a_program() -> None:
    """And every program a sentence; a sentence that is changed in the header is noticed."""
    assert proof.faults(TABLE) == []
    allowed = {name for each in TABLE.sentences for name in each.allows}
    assert allowed <= {each.id for each in variants.load()}
    assert all(each.exercise in {one.id for one in rules().exercises} for each in TABLE.breaches)


def test_a_sentence_without_a_program_is_told() -> None:
    """A new sentence of the header is one until the table has it."""
    header = "/* TP1.1 - A picture all red.\n *\n *   img  is never read; it is all new\n */\n"
    assert contracts.sentences(header) == [
        ("TP1.1", "A picture all red."),
        ("TP1.1", "img is never read;"),
        ("TP1.1", "it is all new"),
    ]
    short = contracts.Contracts(TABLE.breaches, TABLE.sentences[1:])
    assert proof.faults(short) == ["TP1.1: no program breaks: A picture all red."]


def test_where_to_read_more_is_no_sentence() -> None:
    """Nor is the command that judges."""
    header = "/* TP1.1 - All red.\n *\n * Handout 4. Check: make grade TP=1 K=fill_red\n */\n"
    assert contracts.sentences(header) == [("TP1.1", "All red.")]


def test_a_breach_changes_one_function() -> None:
    """What is put in its place stands in the reference once."""
    for each in TABLE.breaches:
        name, written = each.written()
        assert written in each.files()[name]
    with pytest.raises(PatchError, match=r"odd: what comes before stands 2 times in fill_rect"):
        Breach("odd", "TP1.4", "fill_rect", "WIDTH);", "HEIGHT);").files()
    with pytest.raises(PatchError, match=r"odd: the reference has no function fill_all"):
        Breach("odd", "TP1.4", "fill_all", "1", "2").files()


def test_a_malformed_table_is_named(tmp_path: Path) -> None:
    """One line with the file."""
    (tmp_path / "TP1.1.toml").write_text("[breach.odd]\n[sentences]\n", encoding="utf-8")
    with pytest.raises(ManifestError, match=r"TP1\.1\.toml: missing or malformed key: "):
        contracts.load(tmp_path)


FUNCTIONS = sorted({each.function for each in TABLE.breaches})


@pytest.mark.parametrize("function", sampled(FUNCTIONS, FUNCTIONS[1::9], FUNCTIONS[1::18]))
def test_what_breaks_a_sentence_is_caught(function: str, tmp_path: Path) -> None:
    """By a check of the exercise that the sentence is of."""
    chosen = [each for each in TABLE.breaches if each.function == function]
    found = dict(caught(chosen, tmp_path))
    assert [name for name, check in found.items() if not check] == []
    assert found.keys() == {each.id for each in chosen}


def test_the_report_shows_each_sentence_with_its_program() -> None:
    """What is not caught is a fault."""
    breach = TABLE.breaches[0]
    part = proof.report(TABLE, {breach.id: ""}, whole=False)
    assert part.faults == [f"{breach.id}: not caught"]
    assert part.figures["breaches_caught"] == 0
    part = proof.report(TABLE, {breach.id: "tp1.fill_red.every_pixel"}, whole=False)
    assert part.faults == []
    row = ["TP1.1", "img every pixel becomes (1, 0, 0)", breach.id, "tp1.fill_red.every_pixel"]
    assert row in part.rows
