"""What the checks of TP2 to TP5 share.

The inputs and the reference's answers are stored (checking/expected_data.py); each check makes
the calls of its suites and looks at one side of the answers.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from grader.checking.comparison import differs
from grader.checking.expected_data import Array, Batch
from grader.checking.student import Bench, CallDied, Student, Wrong
from grader.course.message import Message

LATER = ("shading", "shadows", "reflections", "fresnel", "refraction")  # fields of `options`


def check_answers(student: Student, suite: str, *picks: str) -> None:
    """Compare parts of the answers to a suite."""
    for trial in student.trials(suite):
        trial.expect(*picks)


def check_refusals(student: Student, *suites: str) -> None:
    """Look at the calls that must return false: they do, and change nothing."""
    for suite in suites:
        for trial in student.trials(suite):
            trial.expect("result", where=trial.refused)
            trial.expect_kept("r", "it", where=trial.refused)


@dataclass(frozen=True)
class Alone:
    """What the submission's intersect_object says of rays and the objects of a scene, one by one.

    `count` is how many each ray meets, `rays` and `hits` are left by the nearest; `sound` marks the
    rays of which that is as stored, and that no refusal has changed; `kept` those of which no
    refusal has changed the intersection.
    """

    rays: Array
    hits: Array
    count: Array
    sound: Array
    kept: Array


def met_alone(bench: Bench, batch: Batch, given: Array) -> Alone:
    """Put the objects of a batch's scene one by one to rays, where the batch is set."""
    rays, count = given.copy(), np.zeros(len(given), int)
    sound, kept = np.ones((2, len(given)), bool)
    hits = bench.core.zeros("intersection", len(given))
    for each in batch.globals["scene"]:
        args = {"r": given, "it": hits.copy(), "obj": np.repeat(each[None], len(given))}
        one = bench.again(Batch("intersect_object", args, {}))
        hit, left = one.got("result").astype(bool), one.got("r")
        sound &= hit | (left["tmax"] == given["tmax"])
        kept &= hit | ~differs(args["it"], one.got("it"))
        nearer = hit & (left["tmax"] < rays["tmax"])
        rays[nearer], hits[nearer] = left[nearer], one.got("it")[nearer]
        count += hit
    stored = batch.answers[0]
    sound &= (count > 0) == stored.result
    if "r" in stored.out:
        sound &= np.isclose(rays["tmax"], stored.out["r"]["tmax"], rtol=1e-3, atol=1e-3)
    return Alone(rays, hits, count, sound, kept)


def check_results(student: Student, *suites: str) -> None:
    """Compare what the calls of suites return."""
    for suite in suites:
        check_answers(student, suite, "result")


def check_stages(student: Student, *suites: str) -> None:
    """Compare what the calls of suites return, at their stage; or else with all the features on.

    Who does without the options, as the handout allows, gives the answers of the last stage always.
    """
    for suite in suites:
        _check_stages(student, suite, empty=False)


def check_stages_of_sky(student: Student, *suites: str) -> None:
    """Compare what the calls of suites return where the scene is empty, at its stage or the last.

    Nothing that is called there looks at the options: an answer that changes with Fresnel comes
    from code that does look, and it has to be right without.
    """
    for suite in suites:
        _check_stages(student, suite, empty=True)


def _check_stages(student: Student, suite: str, *, empty: bool) -> None:
    try:
        check_answers(student, suite, "result")
    except Wrong as first:
        check_last_stage(student, suite, first, empty=empty)


def check_last_stage(student: Student, suite: str, first: Wrong, *, empty: bool = False) -> None:
    """Compare what the calls of a suite return with all the features on. Raises `first`."""
    try:
        with student.unnoted(), student.bench() as bench:
            for batch in student.batches(suite):
                if empty and _looks_at_fresnel(bench, batch):
                    raise first from None
                bench.trial(last_stage(batch)).expect("result")
    except (Wrong, CallDied):
        raise first from None
    student.remarks.append(Message("note.all_features"))


def _looks_at_fresnel(bench: Bench, batch: Batch) -> bool:
    """Say whether the answers change with options.fresnel."""
    without = bench.trial(batch).got("result")
    return not np.array_equal(without, bench.trial(with_options(batch, fresnel=True)).got("result"))


def last_stage(batch: Batch) -> Batch:
    """Return the calls with all the features on: at that stage too there may be several answers."""
    return with_options(batch, **dict.fromkeys(LATER, True))


def with_options(batch: Batch, **settings: bool) -> Batch:
    """Return the calls with these fields of `options`."""
    options = batch.globals["options"].copy()
    for name, value in settings.items():
        options[name] = value
    return replace(batch, globals={**batch.globals, "options": options})
