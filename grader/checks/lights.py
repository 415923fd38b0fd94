"""What light gives, looked at in the submission's own colours: for `shade` and `direct_light`."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from grader.checking.expected_data import Answer, Array
from grader.checking.student import Answers, Student, Wrong

# Of a colour: what must change in it to be seen, a little in every call or clearly in one.
SEEN = 1e-3
BRIGHT = 100.0  # times as bright as what stays below 1


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


def expect_own(trial: Answers, wanted: Array) -> None:
    """Raise Wrong unless the results are what the submission's own ones make."""
    expect_seen(trial, wanted)
    accepted = (Answer(wanted.astype(np.float32), {}),)
    replace(trial, batch=replace(trial.batch, answers=accepted)).expect("result")
