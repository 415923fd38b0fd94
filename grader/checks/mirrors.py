"""TP4.3 - how the checks of mirrors count bounces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from grader.checking.expected_data import Answer, Batch
from grader.checking.student import Student
from grader.checks.common import check_stages


def check_depth(student: Student, suite: str) -> None:
    """Compare colours of several depths; and the last bounce is counted once.

    At which depth its own trace_ray turns black is another exercise's question: the mirror of a ray
    that has one bounce left shows what trace_ray says of the ray that its reflected_ray makes.
    """
    check_stages(student, suite)
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
