"""TP3 - light and matter: Blinn-Phong.

`shade` is judged without Fresnel; answers that have it already are accepted.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from grader.checking.comparison import far
from grader.checking.expected_data import Array, Batch
from grader.checking.student import Answers, Student
from grader.checks.common import check_results
from grader.checks.lights import BRIGHT, SEEN, expect_lit, expect_own, expect_seen
from grader.course.message import Message


@pytest.mark.check("tp3.shade.diffuse")
def test_shade_diffuse(student: Student) -> None:
    """Without specular colour: the light's colour times n.l times kd over pi."""
    (trial,) = student.trials("shade.diffuse")
    expect_by_white(trial)
    got, right = trial.got("result"), trial.batch.answers[0].result
    assert right is not None
    ratio = got[right > SEEN] / right[right > SEEN]
    if np.abs(ratio - np.pi / 3.14).max() < np.pi / 3.14 - 1:  # nearer to it than to 1, each time
        student.remarks.append(Message("note.pi"))


@pytest.mark.check("tp3.shade.lobe")
def test_shade_lobe(student: Student) -> None:
    """Without diffuse colour: the specular lobe around h, with its factor (s + 8) / (8 pi)."""
    for trial in student.trials("shade.lobe"):
        expect_by_white(trial)


def expect_by_white(trial: Answers) -> None:
    """Raise Wrong unless the results are right, or would be if every light were white.

    That the light's colour is a factor is asked of `bright`, once.
    """
    batch, got = trial.batch, trial.got("result")
    colored = got * batch.args["light_color"]
    for each in batch.answers:
        assert each.result is not None
        if not far(colored, each.result, batch.tolerance).any():
            return
    trial.expect("result")


@pytest.mark.check("tp3.shade.both")
def test_shade_both(student: Student) -> None:
    """The two parts are added: what kd adds depends on neither ks nor anything else."""
    (batch,) = student.batches("shade.both")
    with student.bench() as bench:
        whole = bench.trial(batch)
        black = np.zeros(3, np.float32)
        dark = {"ks": black, "kr": black}  # the lobe may be by Fresnel already
        lobe, diffuse, none = (
            bench.trial(with_material(batch, **fields)).got("result")
            for fields in ({"kd": black}, dark, {"kd": black, **dark})
        )
    for part in (diffuse - none, lobe - none):
        expect_seen(whole, part)
    expect_own(whole, lobe + diffuse - none)


def with_material(batch: Batch, **fields: Array) -> Batch:
    """Return calls of shade with other fields of the materials."""
    mat = batch.args["mat"].copy()
    for name, value in fields.items():
        mat[name] = value
    return replace(batch, args={**batch.args, "mat": mat})


def expect_angles(student: Student) -> None:
    """Raise Wrong unless what a light gives changes with an angle, in the diffuse part or the lobe.

    The light's colour times that of the material, whatever the directions, earns nothing.
    """
    diffuse, lobe = student.trials("shade.diffuse")[0], student.trials("shade.lobe")[0]
    for trial, field in ((diffuse, "kd"), (lobe, "ks")):
        color = trial.batch.args["mat"][field] * trial.batch.args["light_color"]
        share = trial.got("result") / np.maximum(color, SEEN)
        if np.ptp(share.max(axis=1)) > SEEN:
            return
    diffuse.expect("result")


@pytest.mark.check("tp3.shade.back")
def test_shade_back(student: Student) -> None:
    """A light behind the surface gives black; one along it does not."""
    expect_lit(student, "shade.diffuse")
    expect_angles(student)
    check_results(student, "shade.back")
    expect_some_light(student, "shade.grazing")


def expect_some_light(student: Student, suite: str) -> None:
    """Raise Wrong where nothing but black is sent; how much it is, is another check's question."""
    for trial in student.trials(suite):
        dark = np.asarray(~trial.got("result").any(axis=1))
        trial.complain(dark, "failure.result", **told(trial))


@pytest.mark.check("tp3.shade.far_lobe")
def test_shade_far_lobe(student: Student) -> None:
    """The lobe adds nothing when h.n is negative, and counts when it is positive."""
    expect_lit(student, "shade.lobe")
    check_results(student, "shade.far_lobe")
    expect_some_light(student, "shade.from_below")


@pytest.mark.check("tp3.shade.shininess")
def test_shade_shininess(student: Student) -> None:
    """A shininess that is no whole number counts as it is."""
    for trial in student.trials("shade.shininess"):
        with np.errstate(invalid="ignore", divide="ignore"):
            log = np.log(trial.got("result").astype(np.float64)[:, 0].reshape(-1, 3))
        low, half, high = log.T
        # From one power to the next the lobe changes by about the same factor each time.
        with np.errstate(invalid="ignore"):
            right = (np.abs(half - (low + high) / 2) < ALIKE) & (np.abs(high - low) > 2 * ALIKE)
        wrong = np.zeros(trial.batch.count, bool)
        wrong[1::3] = ~right
        if wrong.any():
            trial.expect("result", where=wrong)
            trial.complain(wrong, "failure.result", **told(trial))


# Difference of logarithms: 0.25 for a power cut to a whole number, below 0.01 for one that is not.
ALIKE = 0.04


def told(trial: Answers) -> dict[str, object]:
    """Return what came and what is expected, for a sentence."""
    return {"got": trial.got("result"), "expected": trial.batch.answers[0].result}


@pytest.mark.check("tp3.shade.bright")
def test_shade_bright(student: Student) -> None:
    """The light's colour is a factor, however bright it is."""
    expect_angles(student)
    (batch,) = student.batches("shade.both")
    with student.bench() as bench:
        dim = bench.trial(batch).got("result")
        black = {"kd": np.zeros(3, np.float32), "ks": np.zeros(3, np.float32)}
        none = bench.trial(with_material(batch, **black)).got("result")
        color = batch.args["light_color"] * np.float32(BRIGHT)
        bright = bench.trial(replace(batch, args={**batch.args, "light_color": color}))
    expect_seen(bright, dim - none)
    expect_own(bright, dim * BRIGHT)
