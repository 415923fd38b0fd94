"""What the checks of camera_ray share."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from grader.checking.comparison import unit
from grader.checking.expected_data import SIZE
from grader.checking.student import Answers, Student

# Half a pixel too far is another question: along both sides of the picture it is 0.7 of a pixel,
# whose own size is 2 / WIDTH, and more where the camera sees wide.
ABOUT = 2.5 / SIZE[0]
# Mean cosine between the rays and the right ones; it is more where left and right are exchanged.
TOWARDS = 0.2


def check_directions(student: Student, suite: str, tolerance: float = 0.0) -> None:
    """Compare directions, unit or not; by default as exactly as the suite says."""
    for trial in student.trials(suite):
        batch = replace(trial.batch, tolerance=tolerance or trial.batch.tolerance)
        replace(trial, batch=batch).expect("r.dir", by=unit)


def check_about(student: Student, suite: str) -> None:
    """Compare directions, to a pixel or so."""
    check_directions(student, suite, ABOUT)


def looking(student: Student, suite: str = "camera_ray.anywhere") -> Iterator[Answers]:
    """Yield the answers to a suite, if the rays are spread over about what the camera sees."""
    for trial in student.trials(suite):
        got, right = unit(trial.got("r.dir")), unit(trial.batch.answers[0].out["r"]["dir"])
        spread = np.ptp(got, axis=0).max() > ABOUT
        if not (spread and np.einsum("ij,ij->i", got, right).mean() > TOWARDS):
            trial.expect("r.dir", by=unit)
        yield trial
