"""TP5.2 in a function that is wrong without Fresnel already, which TP3.1 or TP4.3 pays for.

What is right is then said by the submission itself: with Fresnel, its answers must be its own ones
without, for materials whose ks is the coefficient. By itself that says nothing: a line that returns
the coefficient would do. So the function must have passed something of its own exercise; or, where
one idea spoils everything, look at all that it has to look at, but for one thing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from grader.checking.comparison import far
from grader.checking.expected_data import Answer, Array, Batch
from grader.checking.student import Bench, CallDied, Student, Wrong
from grader.checks.common import check_results, check_stages, with_options

# Suites of their own exercises: those in which something must be added, then nothing.
SHADE, BACK = ("shade.diffuse", "shade.lobe", "shade.both", "shade.far_lobe"), ("shade.back",)
MIRROR, DEPTH = ("mirror_color.sky", "mirror_color.object"), ("mirror_color.depth",)
# What they have to look at, as arguments and fields.
SHADE_INPUTS = ("n", "v", "l", "light_color", "mat.kd", "mat.ks", "mat.shininess")
MIRROR_INPUTS = ("in.dir", "it.normal", "it.mat.ks", "scene.mat.kd")
OFTEN = 0.25  # of the calls: in so many an answer changes with what is looked at
HALVINGS = 20
LEAST = 0.01  # of a colour: what ks must change in it for the coefficient to be seen
FEW = 0.05  # of the calls in which it must be seen; a lobe that is wrong may be narrow
ROOM = 1000.0  # radius of a white ball around everything, which is what mirrors show
LENGTHS = (2.0, 0.5, 0.25, 3.0)  # of directions that are not unit
SKY = np.array([0.2, 0.2, 0.6], np.float32)


def is_used_in_shade(student: Student) -> bool:
    """Say whether a wrong shade has the coefficient in the place of ks, at whatever angle.

    Half vectors that are wrong give wrong angles, the same ones for the three channels.
    """

    def is_something() -> bool:
        some = [_passes(student, each, check_results) for each in SHADE]
        if all(some) and _passes(student, *BACK, check_results):
            return False  # it is right, and judged by what is expected
        return any(some) or _looks(student, "fresnel_use.lobe", SHADE_INPUTS)

    return _judged(student, is_something, _in_shade)


def is_used_in_mirror(student: Student) -> bool:
    """Say whether a wrong mirror_color has the coefficient in the place of ks."""

    def is_something() -> bool:
        some = [_passes(student, each, check_stages) for each in MIRROR]
        if all(some) and _passes(student, *DEPTH, check_stages):
            return False
        return any(some) or _looks(student, "mirror_color.object", MIRROR_INPUTS)

    return _judged(student, is_something, _in_mirror)


def _judged(
    student: Student, is_something: Callable[[], bool], relation: Callable[[Student, Bench], bool]
) -> bool:
    """Say whether a function is wrong without Fresnel, but something, and a relation holds."""
    try:
        with student.unnoted():
            if not is_something():
                return False
            with student.bench() as bench:
                return relation(student, bench)
    except CallDied:
        return False


def _looks(student: Student, suite: str, inputs: Sequence[str]) -> bool:
    """Say whether the answers without Fresnel change with each of the inputs, but one perhaps."""
    batch = student.batches(suite)[-1]
    with student.bench() as bench:
        before = _without(bench, batch)
        after = (_without(bench, _mixed_up(batch, each.split("."))) for each in inputs)
        seen = [(np.abs(other - before).max(axis=1) > LEAST).mean() > OFTEN for other in after]
    return seen.count(False) <= 1


def _mixed_up(batch: Batch, path: Sequence[str]) -> Batch:
    """Return the calls with another call's value of an argument, or another one of a global."""
    name, *fields = path
    own = batch.globals if name in batch.globals else batch.args
    content = own[name].copy()
    place = content
    for field in fields[:-1]:
        place = place[field]
    value = place[fields[-1]] if fields else place
    value[...] = 1 - value if own is batch.globals else np.roll(value, 1, axis=0)
    changed = {**own, name: content}
    if own is batch.globals:
        return replace(batch, globals=changed, answers=())
    return replace(batch, args=changed, answers=())


def _passes(student: Student, suite: str, check: Callable[[Student, str], None]) -> bool:
    try:
        check(student, suite)
    except Wrong:
        return False
    return True


def _in_shade(student: Student, bench: Bench) -> bool:
    (calls,) = student.batches("fresnel_use.lobe")
    widest = calls.args["mat"].copy()
    widest["shininess"] = 1  # of a narrow lobe, a wrong half vector may leave nothing to see
    calls = replace(calls, args={**calls.args, "mat": widest})
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
    # What the lobe takes from the diffuse part may be more than it adds.
    turn = np.where(whole.sum(axis=1) < none.sum(axis=1), -1.0, 1.0)
    more = turn * got.sum(axis=1)
    # Where the coefficient is less than kr, the angle is that of vectors that are not unit.
    low: Array = np.where(more < turn * none.sum(axis=1), -1.0, 0.0)
    high: Array = np.ones(calls.count)
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        above = turn * without(middle).sum(axis=1) > more
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    follows = ~far(got, without(low), calls.tolerance)
    # kr itself is the coefficient at one angle only. (A half vector turned round always gives 1.)
    is_kr = ~far(got, none, calls.tolerance)
    return bool(follows[seen].all() and not is_kr[seen].all())


def _in_mirror(student: Student, bench: Bench) -> bool:
    """Say it with everything mirrored in a ball: what is wrong may be the sky.

    The ks for which the answers without Fresnel are those with it is looked for, and held against
    the coefficient here: that is what is expected, and is never sent.
    """
    (calls,) = student.batches("fresnel_use.mirror")
    room = bench.core.zeros("object", 1)
    room["type"], room["radius"] = bench.core.constants["SPHERE"], ROOM
    room["mat"]["kd"] = 1
    darker = calls.args["it"].copy()
    darker["mat"]["kd"] /= 2  # where it is mixed with what is seen, the two must not be alike
    calls = replace(calls, args={**calls.args, "it": darker})
    inside = replace(calls, globals={**calls.globals, "scene": room})
    result = calls.answers[0].result
    assert result is not None

    def without(ks: Array) -> Array:
        hits = calls.args["it"].copy()
        hits["mat"]["ks"] = ks
        return _without(bench, inside, it=hits)

    low: Array = np.zeros(result.shape, np.float32)
    high: Array = np.ones(result.shape, np.float32)
    got, slope = bench.trial(inside).got("result"), without(high) - without(low)
    # What ks does not change tells nothing: a constant would follow it too.
    seen = slope.min(axis=1) > LEAST
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        above = without(middle) > got
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    follows = ~far(slope * low, slope * result / SKY, calls.tolerance)
    return bool(seen.mean() > FEW and follows[seen].all())


def expect_any_length(student: Student) -> None:
    """Raise Wrong unless rays that arrive from one direction give the same colour, long or short.

    By the submission's own colours: what is wrong in them is asked about elsewhere.
    """
    (calls,) = student.batches("fresnel_use.mirror")
    with student.bench() as bench:
        own = Answer(bench.trial(calls).got("result"), calls.answers[0].out)
        bench.trial(replace(_lengthened(calls), answers=(own,))).expect("result")


def _lengthened(calls: Batch) -> Batch:
    """Return the calls with rays whose directions are not unit."""
    rays = calls.args["in"].copy()
    factors = np.resize(np.array(LENGTHS, np.float32), calls.count)
    rays["dir"] *= factors[:, None]
    rays["tmax"] /= factors
    return replace(calls, args={**calls.args, "in": rays})


def _without(bench: Bench, calls: Batch, **changed: Array) -> Array:
    """Return what the calls give without Fresnel, with other arguments."""
    arguments: Mapping[str, Array] = {**calls.args, **changed}
    batch = with_options(replace(calls, args=arguments), fresnel=False)
    return bench.trial(batch).got("result")
