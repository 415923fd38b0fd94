"""What the checks of the four intersection functions share.

Each check asks one question of a hit, so that one mistake is paid for once: which rays hit is asked
of "result" alone, and what a hit is like where the submission has found it. A point is judged by
the submission's own t, a direction that is not unit by its own answers to the unit one.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from grader.checking.comparison import MATERIAL, far, unit
from grader.checking.expected_data import Answer, Array
from grader.checking.student import Answers, Student, Wrong

FOUND = 0.25  # of the hits: a submission that finds fewer is not asked what they are like
COMPUTED = 0.5  # of the hits: in which a t or a point is right, or they agree
KEPT = ("orig", "dir", "tmin", "depth", "seed")  # of a ray, whatever it meets


def check_meets(student: Student, suite: str) -> None:
    """Compare which rays hit."""
    for trial in student.trials(suite):
        trial.expect("result")
        expect_computed(trial)


def check_missed(student: Student, suite: str) -> None:
    """Look whether rays that must miss do; it counts for a function that finds hits as well."""
    expect_work(student, suite)
    for trial in student.trials(suite):
        trial.expect("result")


def check_distance(student: Student, suite: str) -> None:
    """Compare the t of the hits."""
    for trial in student.trials(suite):
        trial.expect("r.tmax", where=met(trial))


def check_position(student: Student, suite: str) -> None:
    """Look whether the points hit are those of the rays at t: the submission's own, if it is."""
    for trial in student.trials(suite):
        expect_computed(trial)
        found = met(trial)
        with contextlib.suppress(Wrong):
            own = judged_by(trial.aside(), "it.position", own_points(trial))
            own.expect("it.position", where=found)
            continue
        trial.expect("it.position", where=found)


def check_distance_and_position(student: Student, suite: str) -> None:
    """Compare the t of the hits, and the points."""
    check_distance(student, suite)
    check_position(student, suite)


def check_normal(student: Student, suite: str) -> None:
    """Compare the normals of the hits."""
    for trial in student.trials(suite):
        expect_computed(trial)
        trial.expect("it.normal", where=met(trial))


def check_sphere_normal(student: Student, suite: str) -> None:
    """Compare the normals with those of the right points, or of the submission's own."""
    for trial in student.trials(suite):
        expect_computed(trial)
        found, centre = met(trial), trial.batch.args["obj"]["center"]
        own = unit(trial.got("it.position") - centre).astype(np.float32)
        with contextlib.suppress(Wrong):
            judged_by(trial.aside(), "it.normal", own).expect("it.normal", where=found)
            continue
        trial.expect("it.normal", where=found)


def check_material(student: Student, suite: str) -> None:
    """Compare the whole material of what is hit."""
    for trial in student.trials(suite):
        expect_computed(trial)
        trial.expect(*(f"it.mat.{name}" for name in MATERIAL), where=met(trial))


def check_inside(student: Student, suite: str) -> None:
    """Compare hits from inside: found, at the point where the ray leaves, the normal outwards.

    That tmax is never lowered is asked of `distance`: here, whether it is from inside too.
    """
    (front,) = student.trials(suite.replace("inside", "front"))
    lowers = (front.got("r.tmax") != front.batch.args["r"]["tmax"])[met(front)].mean() > COMPUTED
    for trial in student.trials(suite):
        trial.expect("result")
        expect_placed(trial)
        if lowers:
            trial.expect("r.tmax", where=trial.got("r.tmax") == trial.batch.args["r"]["tmax"])
        trial.expect("it.normal", by=unit)


def check_caps(student: Student, suite: str) -> None:
    """Compare hits on a disc, from outside and from inside: one side alone names no mistake."""

    def look(trial: Answers) -> None:
        trial.expect("result")
        expect_placed(trial)
        trial.expect("it.normal")

    _look_at_all(student, suite, look)


def check_range(student: Student, suite: str) -> None:
    """Compare which rays hit when their range leaves out one point, or both."""
    for trial in student.trials(suite):
        trial.expect("result")
        expect_placed(trial)


def check_scaled(student: Student, suite: str) -> None:
    """Look whether rays whose directions are not unit hit the same points, at a t in their units.

    They are compared with what the submission itself answers to the unit ones.
    """
    long, unit = student.trials(suite)
    alike = unit.got("result").astype(bool)
    steps = np.linalg.norm(long.batch.args["r"]["dir"].astype(np.float64), axis=1)
    own = {**unit.answer.out, "r": unit.answer.out["r"].copy()}
    is_kept = unit.got("r.tmax") == unit.batch.args["r"]["tmax"]  # never written, as is told apart
    own["r"]["tmax"] = np.where(is_kept, own["r"]["tmax"], own["r"]["tmax"] / steps)
    expect_computed(unit)
    answers = (Answer(unit.answer.result, own),)
    replace(long, batch=replace(long.batch, answers=answers)).expect(
        "result", "r.tmax", "it.position", where=alike
    )


def check_nearest(student: Student, suite: str) -> None:
    """Compare the nearest hits in scenes, all of them: one ray alone names no mistake."""
    _look_at_all(student, suite, lambda each: each.expect("r.tmax", "it.position", "it.mat.kd"))


def _look_at_all(student: Student, suite: str, look: Callable[[Answers], None]) -> None:
    """Look at every batch of a suite, also behind one that is wrong. Raises the first Wrong."""
    first: Wrong | None = None
    for trial in student.trials(suite):
        try:
            look(trial)
        except Wrong as wrong:
            first = first or wrong
    if first:
        raise first


def check_range_and_scale(student: Student, ranges: str, scaled: str) -> None:
    """Compare which rays hit by their range, and what t is where directions are not unit."""
    check_range(student, ranges)
    check_scaled(student, scaled)


def check_only(student: Student, *suites: str) -> None:
    """Look whether a hit changes nothing of the ray but tmax."""
    for trial in (each for suite in suites for each in student.trials(suite)):
        expect_computed(trial)
        before = {**trial.answer.out, "r": trial.batch.args["r"]}
        kept = replace(trial.batch, answers=(Answer(trial.answer.result, before),), tolerance=1e-5)
        replace(trial, batch=kept).expect(*(f"r.{name}" for name in KEPT), where=met(trial))


def check_refusals(student: Student, *suites: str) -> None:
    """Look at the calls that must return false: where they do, they change nothing.

    Those that return true are another check's question; but some must be refused.
    """
    expect_work(student, suites[0])
    for suite in suites:
        for trial in student.trials(suite):
            refused = trial.refused & ~trial.got("result").astype(bool)
            # Who takes no notice of the range pays for it there.
            if not suite.endswith(".range") and refused.sum() < FOUND * trial.refused.sum():
                trial.expect("result", where=trial.refused)
            trial.expect_kept("r", "it", where=refused)


def expect_work(student: Student, suite: str) -> None:
    """Raise Wrong unless the function of a suite finds hits, and computes something of them."""
    for trial in student.trials(f"{suite.partition('.')[0]}.front"):
        expect_computed(trial)


def met(trial: Answers) -> Array:
    """Return which calls hit, by the reference and by the submission.

    Raises Wrong when the submission finds few of the hits.
    """
    right = ~trial.refused
    found: Array = right & trial.got("result").astype(bool)
    if found.sum() < FOUND * right.sum():
        trial.expect("result", where=right)
    return found


def own_points(trial: Answers) -> Array:
    """Return the points of the rays at the submission's own t."""
    rays = trial.batch.args["r"]
    with np.errstate(invalid="ignore", over="ignore"):
        points: Array = rays["orig"] + trial.got("r.tmax")[:, None] * rays["dir"]
    return points


def judged_by(trial: Answers, pick: str, wanted: Array) -> Answers:
    """Return the answers, to be judged by other values of a part such as "it.position"."""
    name, field = pick.split(".")
    out = {**trial.batch.answers[0].out}
    out[name] = out[name].copy()
    out[name][field] = wanted
    answer = Answer(trial.batch.answers[0].result, out)
    return replace(trial, batch=replace(trial.batch, answers=(answer,)))


def expect_placed(trial: Answers) -> None:
    """Raise Wrong unless the hits are where they should be, by their t or by their points."""
    found = met(trial)
    for pick in ("r.tmax", "it.position"):
        with contextlib.suppress(Wrong):
            trial.aside().expect(pick, where=found)
            return
    trial.expect("r.tmax", where=found)


def expect_computed(trial: Answers) -> None:
    """Raise Wrong unless something of the hits has been computed: what is copied earns nothing.

    In most of them t or the point is right, or the point is that of the ray at t: at a t that is
    not the same whatever is asked.
    """
    found, tolerance = met(trial), trial.batch.tolerance
    accepted = trial.batch.answers[0].out
    t, point = trial.got("r.tmax"), trial.got("it.position")
    moved = (t != trial.batch.args["r"]["tmax"]) & (np.ptp(t[found]) > 0)
    signs = (
        ~far(t, accepted["r"]["tmax"], tolerance),
        ~far(point, accepted["it"]["position"], tolerance),
        moved & (t > trial.batch.args["r"]["tmin"]) & ~far(point, own_points(trial), tolerance),
    )
    if not any(each[found].mean() >= COMPUTED for each in signs):
        trial.expect("r.tmax", where=found)
