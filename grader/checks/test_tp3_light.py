"""TP3 - the sum of the lights.

`direct_light` is judged without Fresnel; answers that have it already are accepted.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from grader.checking.comparison import far
from grader.checking.expected_data import Array, Batch, counted
from grader.checking.student import Answers, Bench, Student, Wrong
from grader.checks.common import check_results
from grader.checks.lights import BRIGHT, SEEN, expect_lit, expect_own, expect_seen


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
