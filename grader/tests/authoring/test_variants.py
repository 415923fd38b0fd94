"""Right solutions written differently: they get every point."""

from __future__ import annotations

from pathlib import Path

import pytest

from grader.authoring.specimens import variants
from grader.authoring.specimens.grading import graded, lost
from grader.authoring.specimens.patches import reference
from grader.course.exercises import ManifestError
from grader.evaluation.records import Outcome
from grader.tests.support.sampling import sampled

ALL = {each.id: each for each in variants.load()}
# Of every kind: a function in another arithmetic, another convention, another structure.
SAMPLE = ("one_loop", "sphere_geometric", "shade_double", "bvh", "samples_jittered")


def test_every_variant_differs_from_the_reference() -> None:
    """Thirty at least, each by its files, its flags or its compiler; no file lies idle."""
    assert len(ALL) >= 30
    base = reference()
    plain = [each.id for each in ALL.values() if not (each.flags or each.compiler)]
    assert [name for name in plain if ALL[name].files() == base] == ["reference"]
    stems = {path.stem for path in variants.FOLDER.iterdir() if path.suffix != ".toml"}
    assert stems <= set(ALL)


@pytest.mark.parametrize("name", sampled(SAMPLE, SAMPLE, SAMPLE[:2]))
def test_a_right_solution_gets_every_point(name: str, cache: Path) -> None:
    """Each on the TPs that it is about; `make prove` runs them all."""
    variant = ALL[name]
    for tp in variant.tps:
        checks = graded(variant.submission(), cache, tp, variant.flags, variant.compiler)
        assert [(each.id, each.message) for each in lost(checks)] == []
        assert {each.tp for each in checks} == {tp}


def test_a_malformed_list_is_named(tmp_path: Path) -> None:
    """One line with the file."""
    path = tmp_path / "variants.toml"
    path.write_text("[variant.odd]\n", encoding="utf-8")
    with pytest.raises(ManifestError, match=r"variants\.toml: missing or malformed key: 'about'"):
        variants.load(path)


def test_what_is_not_begun_is_to_do_with_its_pictures(cache: Path) -> None:
    """Everything inside trace_ray: the pictures are right, and count once a function is."""
    checks = {each.id: each for each in graded(ALL["all_in_trace_ray"].submission(), cache, 4)}
    assert {each.outcome for each in lost(list(checks.values()))} == {Outcome.TODO}
    picture = checks["tp4.scene.shadows_0"]
    assert (picture.points, picture.pixel) == (0, None)
    assert "(in_shadow)" in picture.message
