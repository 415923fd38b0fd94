"""TP3 - light and matter: Blinn-Phong, the sum of the lights.

`shade` and `direct_light` are judged without Fresnel; answers that have it already are accepted.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from grader.checking.comparison import far
from grader.checking.expected_data import Answer, Array, Batch, counted
from grader.checking.student import Answers, Bench, Student, Wrong
from grader.checks.common import check_results
from grader.course.message import Message

# ---- TP3.1: shade -------------------------------------------------------------------------------

# Of a colour: what must change in it to be seen, a little in every call or clearly in one.
SEEN = 1e-3


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


def expect_seen(trial: Answers, seen: Array) -> None:
    """Raise Wrong unless a part is seen in most of the calls: nothing at all earns nothing."""
    if not (np.abs(seen).max(axis=1) > SEEN).mean() > 0.25:
        trial.expect("result")
        raise Wrong("failure.flat_picture")


def expect_lit(student: Student, suite: str) -> None:
    """Raise Wrong unless what light from the front gives is seen, and not the same everywhere."""
    for trial in student.trials(suite):
        got = trial.got("result")
        expect_seen(trial, got - got[0])


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


BRIGHT = 100.0  # times as bright as what stays below 1


# ---- TP3.2: direct_light ------------------------------------------------------------------------


@pytest.mark.check("tp3.direct_light.sum")
def test_direct_light_sum(student: Student) -> None:
    """With several lights: the sum of what each gives."""
    for batch in student.batches("direct_light.sum"):
        lights = batch.globals["lights"]
        with student.bench() as bench:
            whole = lit_by(bench, batch, lights)
            none = lit_by(bench, batch, lights[:0]).got("result")
            parts = [
                lit_by(bench, batch, lights[k : k + 1]).got("result") - none
                for k in range(len(lights))
            ]
            expect_place(bench, batch)
        added = np.sum(parts, axis=0)
        expect_light(whole, added)
        expect_own(whole, none + added)


def expect_light(trial: Answers, added: Array) -> None:
    """Raise Wrong unless lights add something, which is not the same everywhere."""
    for seen in (added, added - added[0]):
        expect_seen(trial, seen)


def expect_place(bench: Bench, batch: Batch) -> None:
    """Raise Wrong unless it matters where lights are, or where the surface looks.

    Adding up the colours of the lights earns nothing.
    """
    hits, lights = batch.args["it"].copy(), batch.globals["lights"].copy()
    hits["normal"] *= -1
    lights["position"] *= -1
    whole = lit_by(bench, batch, batch.globals["lights"])
    changed = [
        lit_by(bench, replace(batch, args={**batch.args, "it": hits}), batch.globals["lights"]),
        lit_by(bench, batch, lights),
    ]
    expect_seen(whole, sum(np.abs(each.got("result") - whole.got("result")) for each in changed))


def lit_by(bench: Bench, batch: Batch, lights: Array) -> Answers:
    """Make calls under other lights; nothing but black ones stands beyond them."""
    dark = np.zeros_like(batch.globals["lights"])
    bench.prepare(replace(batch, globals={**batch.globals, "lights": dark}))
    few = {name: value for name, value in batch.globals.items() if name != "num_lights"}
    return bench.trial(replace(batch, globals={**few, "lights": lights}))


def expect_own(trial: Answers, wanted: Array) -> None:
    """Raise Wrong unless the results are what the submission's own ones make."""
    expect_seen(trial, wanted)
    accepted = (Answer(wanted.astype(np.float32), {}),)
    replace(trial, batch=replace(trial.batch, answers=accepted)).expect("result")


@pytest.mark.check("tp3.direct_light.bright")
def test_direct_light_bright(student: Student) -> None:
    """The sum is not limited to 1."""
    for batch in student.batches("direct_light.bright"):
        bright = batch.globals["lights"]
        dim = bright.copy()
        dim["col"] /= BRIGHT
        with student.bench() as bench:
            expect_place(bench, replace(batch, globals={**batch.globals, "lights": dim}))
            none = lit_by(bench, batch, bright[:0]).got("result")
            added = lit_by(bench, batch, dim).got("result") - none
            whole = lit_by(bench, batch, bright)
        expect_light(whole, BRIGHT * added)
        expect_own(whole, none + BRIGHT * added)


@pytest.mark.check("tp3.direct_light.none")
def test_direct_light_none(student: Student) -> None:
    """Without any light: black."""
    expect_lit(student, "direct_light.one")
    with student.bench() as bench:
        expect_place(bench, student.batches("direct_light.one")[0])
    check_results(student, "direct_light.none")


@pytest.mark.check("tp3.direct_light.count")
def test_direct_light_count(student: Student) -> None:
    """What stands in lights[] from num_lights on gives no light."""
    for batch in student.batches("direct_light.count"):
        few = batch.globals["lights"][: counted(batch.globals, "lights")]
        with student.bench() as bench:
            whole = bench.trial(batch)
            wanted = lit_by(bench, batch, few).got("result")
            expect_light(whole, wanted - lit_by(bench, batch, few[:0]).got("result"))
            expect_place(bench, batch)
        expect_own(whole, wanted)


@pytest.mark.check("tp3.direct_light.barred")
def test_direct_light_barred(student: Student) -> None:
    """From TP4.1 on: the lights that come after a barred one count."""
    barred, free = student.batches("direct_light.barred")
    with student.bench() as bench:
        both = bench.trial(barred)
        turned = lit_by(bench, barred, barred.globals["lights"][::-1])
        alone = lit_by(bench, free, free.globals["lights"]).got("result")
        none = lit_by(bench, free, free.globals["lights"][:0]).got("result")
        expect_place(bench, free)
    expect_light(both, alone - none)
    # In both orders, which tell a light that is given up from one that is asked about wrongly.
    seen, within = turned.got("result"), barred.tolerance
    student.observations.note("turned", seen, far(seen, alone, within), within)
    for trial in (both, turned):
        less = np.asarray((trial.got("result") < LEFT * alone).any(axis=1))
        trial.complain(less, "failure.result", got=trial.got("result"), expected=alone)


@pytest.mark.check("tp3.direct_light.behind")
def test_direct_light_behind(student: Student) -> None:
    """A point seen from behind is lit as it is: its normal stays where it is."""
    try:
        check_results(student, "direct_light.behind")
    except Wrong as first:
        for batch in student.batches("direct_light.behind"):
            expect_no_eye(student, batch, first)


def expect_no_eye(student: Student, batch: Batch, first: Wrong) -> None:
    """Raise `first` unless the side of the eye changes nothing of what the diffuse part gives.

    How much it is, is asked of `one`.
    """
    hits = batch.args["it"].copy()
    hits["mat"]["ks"] = hits["mat"]["kr"] = 0
    matte = replace(batch, args={**batch.args, "it": hits})
    with student.bench() as bench:
        expect_place(bench, batch)
        behind = bench.trial(matte).got("result")
        front = bench.trial(replace(matte, args={**matte.args, "v": -batch.args["v"]}))
    is_lit = (front.got("result").max(axis=1) > SEEN).mean() > 0.25
    if not is_lit or far(behind, front.got("result"), batch.tolerance).any():
        raise first from None


LEFT = 0.4  # of the light that is not barred: a mean of two has half of it
