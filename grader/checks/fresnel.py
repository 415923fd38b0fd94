"""TP5.2 in a function that is wrong without Fresnel already, which TP3.1 or TP4.3 pays for.

What is right is then said by the submission itself: with Fresnel, its answers must be its own ones
without, for materials whose ks is the coefficient.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from grader.checking.comparison import far
from grader.checking.expected_data import Array, Batch
from grader.checking.observations import Observations
from grader.checking.student import Bench, CallDied, Student, Wrong
from grader.checks.common import check_results, check_stages, with_options

SHADE = ("shade.diffuse", "shade.lobe", "shade.both", "shade.far_lobe", "shade.back")
MIRROR = ("mirror_color.sky", "mirror_color.object", "mirror_color.depth")
HALVINGS = 20
LEAST = 0.01  # of a colour: what ks must change in it for the coefficient to be seen
FEW = 0.05  # of the calls in which it must be seen; a lobe that is wrong may be narrow
ROOM = 1000.0  # radius of a white ball around everything, which is what mirrors show
SKY = np.array([0.2, 0.2, 0.6], np.float32)


def is_used_in_shade(student: Student) -> bool:
    """Say whether a wrong shade has the coefficient in the place of ks, at whatever angle.

    Half vectors that are wrong give wrong angles, the same ones for the three channels.
    """
    return _judged(student, SHADE, check_results, _in_shade)


def is_used_in_mirror(student: Student) -> bool:
    """Say whether a wrong mirror_color has the coefficient in the place of ks."""
    return _judged(student, MIRROR, check_stages, _in_mirror)


def _judged(
    student: Student,
    suites: tuple[str, ...],
    check: Callable[[Student, str], None],
    relation: Callable[[Student, Bench], bool],
) -> bool:
    """Say whether a function fails its own exercise's suites, and a relation holds in it."""
    noted, student.observations = student.observations, Observations()
    try:
        if not _fails(student, suites, check):
            return False
        with student.bench() as bench:
            return relation(student, bench)
    except CallDied:
        return False
    finally:
        student.observations = noted


def _fails(
    student: Student, suites: tuple[str, ...], check: Callable[[Student, str], None]
) -> bool:
    try:
        for suite in suites:
            check(student, suite)
    except Wrong:
        return True
    return False


def _in_shade(student: Student, bench: Bench) -> bool:
    (calls,) = student.batches("fresnel_use.lobe")
    got = bench.trial(calls).got("result")
    kr = calls.args["mat"]["kr"]

    def without(part: Array) -> Array:
        """Return what shade gives without Fresnel, by how much of what kr leaves is reflected."""
        mat = calls.args["mat"].copy()
        mat["ks"] = kr + (1 - kr) * part[:, None]
        return _without(bench, calls, mat=mat)

    none, whole = without(np.zeros(calls.count)), without(np.ones(calls.count))
    seen = np.abs(whole - none).min(axis=1) > LEAST
    if seen.mean() < FEW:
        return False
    # Where the coefficient is less than kr, the angle is that of vectors that are not unit.
    low: Array = np.where(got.sum(axis=1) < none.sum(axis=1), -1.0, 0.0)
    high: Array = np.ones(calls.count)
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        above = without(middle).sum(axis=1) > got.sum(axis=1)
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    follows = ~far(got, without(low), calls.tolerance)
    # kr itself is the coefficient at one angle only. (A half vector turned round always gives 1.)
    is_kr = ~far(got, none, calls.tolerance)
    return bool(follows[seen].all() and not is_kr[seen].all())


def _in_mirror(student: Student, bench: Bench) -> bool:
    """Say it with everything mirrored in a ball: what is wrong may be the sky."""
    (calls,) = student.batches("fresnel_use.mirror")
    room = bench.core.zeros("object", 1)
    room["type"], room["radius"] = bench.core.constants["SPHERE"], ROOM
    room["mat"]["kd"] = 1
    inside = replace(calls, globals={**calls.globals, "scene": room})
    result = calls.answers[0].result
    assert result is not None
    hits, dull = calls.args["it"].copy(), calls.args["it"].copy()
    hits["mat"]["ks"], dull["mat"]["ks"] = result / SKY, 0
    with_it, without = bench.trial(inside).got("result"), _without(bench, inside, it=hits)
    # What ks does not change tells nothing: a constant would follow it too.
    seen = np.abs(without - _without(bench, inside, it=dull)).min(axis=1) > LEAST
    follows = ~far(with_it, without, calls.tolerance)
    return bool(seen.mean() > FEW and follows.all())


def _without(bench: Bench, calls: Batch, **changed: Array) -> Array:
    """Return what the calls give without Fresnel, with other arguments."""
    arguments: Mapping[str, Array] = {**calls.args, **changed}
    batch = with_options(replace(calls, args=arguments), fresnel=False)
    return bench.trial(batch).got("result")
