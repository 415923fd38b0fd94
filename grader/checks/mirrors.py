"""TP4.3 - how the checks of mirrors count bounces, and tell what is seen from how strongly."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from grader.checking.expected_data import Answer, Array, Batch
from grader.checking.student import CallDied, Student, Wrong
from grader.checks.common import check_stages, check_stages_of_sky

SEEN = 1e-3  # of a colour


def check_sky(student: Student, suite: str) -> None:
    """Compare what is seen in mirrors of the sky; it counts for who does not see it everywhere."""
    for trial in student.trials("mirror_color.object"):
        k, got = trial.batch.args["it"]["mat"]["ks"], trial.got("result")
        if np.ptp(got / k, axis=0).max() < SEEN and got.any():
            trial.expect("result")
    check_stages_of_sky(student, suite)


def check_seen(student: Student, suite: str) -> None:
    """Compare what is seen in mirrors; how strongly is asked of `sky` and of `channels`.

    What is seen without any coefficient, or by one that is 1 here, is accepted: it is forgotten, or
    another one, in every mirror alike. So is what is seen besides something of the mirror's own,
    which is added to all that is seen alike: that is asked of `alone`.
    """
    try:
        check_stages(student, suite)
    except Wrong as first:
        try:
            with student.unnoted():
                for trial in student.trials(suite):
                    (stored, *_), k = trial.batch.answers, trial.batch.args["it"]["mat"]["ks"]
                    accepted = [stored.result / k]
                    if not suite.endswith(".alone"):
                        accepted.append(stored.result + _unseen(student, trial.batch))
                    answers = tuple(Answer(each, stored.out) for each in accepted)
                    replace(trial, batch=replace(trial.batch, answers=answers)).expect("result")
        except (Wrong, CallDied):
            raise first from None


def _unseen(student: Student, batch: Batch) -> Array:
    """Return what mirrors of the submission's own give where the last bounce sees nothing."""
    args = {name: each.copy() for name, each in batch.args.items()}
    args["in"]["depth"] = batch.globals["options"]["max_depth"]
    with student.bench() as bench:
        return bench.trial(replace(batch, args=args)).got("result")


def check_depth(student: Student, suite: str) -> None:
    """Compare colours of several depths; and the last bounce is counted once.

    At which depth its own trace_ray turns black is another exercise's question: the mirror of a ray
    that has one bounce left shows what trace_ray says of the ray that its reflected_ray makes.
    """
    check_seen(student, suite)
    for batch in student.batches(suite):
        args = {name: each.copy() for name, each in batch.args.items()}
        args["in"]["depth"] = batch.globals["options"]["max_depth"] - 1
        with student.bench() as bench:
            trial = bench.trial(replace(batch, args=args))
            out = bench.core.zeros("ray", batch.count)
            reflected = bench.again(Batch("reflected_ray", {"out": out, **args}, {}))
            seen = bench.again(Batch("trace_ray", {"r": reflected.got("out")}, {})).got("result")
        own = Answer(seen * args["it"]["mat"]["ks"], trial.answer.out)
        dark = np.asarray(~trial.got("result").any(axis=1))
        forgotten = dark & np.asarray(seen.any(axis=1))
        replace(trial, batch=replace(trial.batch, answers=(own,))).expect("result", where=forgotten)
