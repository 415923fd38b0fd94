"""TP2.6 - what the checks of trace_ray ask beside its colours, of whoever gets those wrong too."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from grader.checking.comparison import far
from grader.checking.student import CallDied, Student, Wrong
from grader.checks.common import check_stages

SEEN = 1e-2  # of a colour: objects differ by more
BRIGHT = 1.5  # a channel that is not limited to 1, however the colour is mixed


def check_sky(student: Student, suite: str) -> None:
    """Compare the colours of rays that meet nothing; it counts for who sees what others meet."""
    expect_seen(student)
    check_stages(student, suite)


def check_depth(student: Student, suite: str) -> None:
    """Compare colours of several depths: with the submission's own at depth 0, if they are wrong.

    Beyond the limit it is black that is right.
    """
    _check_or(student, suite, _stops_in_depth)


def check_bright(student: Student, suite: str) -> None:
    """Compare colours that exceed 1; of those that are wrong, whether they do."""
    _check_or(student, suite, _exceeds)


def expect_seen(student: Student) -> None:
    """Raise Wrong where every ray has one colour, whatever it meets."""
    for trial in student.trials("trace_ray.object"):
        if trial.batch.count > 1 and np.ptp(trial.got("result"), axis=0).max() < SEEN:
            trial.expect("result")


def _check_or(student: Student, suite: str, holds: Callable[[Student, str], bool]) -> None:
    """Compare what is returned; what `holds` is as good where it is computed."""
    try:
        check_stages(student, suite)
    except Wrong as first:
        try:
            with student.unnoted():
                expect_seen(student)
                if not holds(student, suite):
                    raise first from None
        except (Wrong, CallDied):
            raise first from None


def _stops_in_depth(student: Student, suite: str) -> bool:
    for batch in student.batches(suite):
        args = {"r": batch.args["r"].copy()}
        args["r"]["depth"] = 0
        with student.bench() as bench:
            got = bench.trial(batch).got("result")
            own = bench.trial(replace(batch, args=args)).got("result")
        deep = batch.args["r"]["depth"] > batch.globals["options"]["max_depth"]
        if far(got, np.where(deep[:, None], 0, own), batch.tolerance).any():
            return False
    return True


def _exceeds(student: Student, suite: str) -> bool:
    for trial in student.trials(suite):
        right = trial.batch.answers[0].result
        assert right is not None
        if not (trial.got("result")[right > BRIGHT] > 1).all():
            return False
    return True
