"""Stored calls have one right answer: what rounding decides is left out."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from grader.authoring.expected.suites import recipes
from grader.authoring.expected.vectors.bounces import clear, shifted
from grader.authoring.expected.vectors.maker import Maker, Question, floats, stack
from grader.authoring.specimens import variants
from grader.checking.comparison import far
from grader.checking.expected_data import SIZE, Batch, prepare, run
from grader.checks.common import last_stage
from grader.course.exercises import ROOT
from grader.execution.session import Library, Limits, open_core

CLOSE = 1e-3


@pytest.fixture(scope="module")
def core(cache: Path) -> Iterator[Library]:
    """Return the reference, at the size of the data."""
    with open_core(ROOT / "reference", *SIZE, cache=cache) as core:
        yield core


@pytest.fixture
def maker(core: Library) -> Iterator[Maker]:
    """Return a maker of inputs."""
    with core.session(Limits(cpu=60)) as session:
        yield Maker(core, session, 7)


def two_mirrors(maker: Maker) -> Batch:
    """Return rays at two balls that nearly touch: at the side of one, and into their gap."""
    balls = maker.objects("SPHERE", 2, maker.materials(2, kd=0.5, ks=0.9, kr=0.9), radius=1)
    balls["center"] = [(-1.0001, 0, 0), (1.0001, 0, 0)]
    rays = maker.rays([(-1.5, 0.2, 5), (0.0013, 0.0007, 5)], [(0, 0, -1), (0, 0, -1)])
    lamp = maker.lights([(2, 3, 9)], [(1, 1, 1)])
    return Batch("trace_ray", {"r": rays}, maker.world(balls, lamp))


def test_what_rounding_decides_is_left_out(maker: Maker) -> None:
    """A ray into the gap between two mirrors goes; one that bounces off the side of one stays."""
    batch = two_mirrors(maker)
    kept = clear(maker, Question(batch, (batch,)), CLOSE)
    assert kept.batch.args["r"]["orig"].tolist() == batch.args["r"]["orig"][:1].tolist()
    assert kept.variants[0].count == 1


def test_objects_of_every_type_move_with_the_calls(maker: Maker) -> None:
    """A scene seen from elsewhere, all of it moved alike, has the same colours."""
    kinds = ("SPHERE", "PLANE", "CYLINDER", "CONE")
    scene = stack(*(maker.objects(kind, 1) for kind in kinds))
    scene["mat"]["pattern"] = int(maker.core.constants["PATTERN_CHECKER"])
    scene["mat"]["pattern_size"] = 50
    scene["center"][0], scene["radius"][0] = (0, 0, 0), 1
    scene["normal"][1], scene["dist"][1] = (0, 1, 0), 2
    for k, place in ((2, (-4, -1, 0)), (3, (4, -1, 0))):
        scene["base"][k], scene["axis"][k] = place, (0, 1, 0)
        scene["length"][k], scene["radius"][k] = 2, 1
    starts = [(0.1, 0, 6), (1, 2, 6), (-4, 0.2, 6), (4, -0.5, 6)]
    rays = maker.rays(starts, [(0, 0, -1), (0, -0.6, -0.8), (0, 0, -1), (0, 0, -1)])
    world = maker.world(scene, maker.lights([(2, 9, 9)], [(1, 1, 1)]), reflections=False)
    batch = Batch("trace_ray", {"r": rays}, world)
    moved = shifted(maker, batch, floats([8, -16, 4]))
    before, after = (maker.ask(each).answers[0].result for each in (batch, moved))
    assert before is not None
    assert after is not None
    assert (before.max(axis=1) > 0.05).all()
    assert not far(after, before, CLOSE).any()
    assert np.allclose(rays["orig"], starts)  # the first are as they were


def test_no_cone_is_met_at_its_tip(core: Library) -> None:
    """There a rounding turns the normal by more than is allowed, whichever the inputs are."""
    (front,) = [each for each in recipes() if each.name == "intersect_cone.front"]
    with core.session(Limits(cpu=60)) as session:
        (question,) = front.suite(core, session, 14).questions
    cone, answer = question.batch.args["obj"], question.batch.answers[0]
    tip = cone["base"] + cone["axis"] * cone["length"][:, None]
    away = np.linalg.norm(answer.out["it"]["position"] - tip, axis=1)
    assert len(away) > 50
    assert (away > 0.2 * cone["length"]).all()


@pytest.mark.parametrize("seed", [4, 11])
def test_fresh_inputs_are_fair_to_who_ignores_the_options(
    seed: int, core: Library, cache: Path, tmp_path: Path
) -> None:
    """With everything on, another right program gives one of the answers that are stored."""
    (ignoring,) = [each for each in variants.load() if each.id == "options_ignored"]
    for name, text in ignoring.files().items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    traced = [each for each in recipes() if each.name.startswith("trace_ray.")]
    with open_core(tmp_path, *SIZE, cache=cache) as other:
        for recipe in traced:
            with core.session(Limits(cpu=60)) as session:
                suite = recipe.suite(core, session, seed)
            for question in suite.questions:
                on = last_stage(question.batch)
                with other.session() as session:
                    prepare(session, other, on)
                    got = run(session, other, on).result
                assert got is not None
                ways = [each.result for each in on.answers if each.result is not None]
                assert any(not far(got, each, suite.tolerance).any() for each in ways)
