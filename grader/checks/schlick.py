"""TP5.1 - how the checks of fresnel_schlick look at its ends."""

from __future__ import annotations

import numpy as np

from grader.checking.student import Student
from grader.checks.common import check_results

STEP = 0.01  # of what is not reflected at normal incidence: shares that differ by less are one
SHARES = 3  # as kr, white, and one more: fewer are chosen, and not computed


def check_end(student: Student, suite: str) -> None:
    """Compare the coefficient at an end of the angles; it counts for who computes between them."""
    for trial in student.trials("fresnel_schlick.angle"):
        kr = trial.batch.args["kr"]
        with np.errstate(invalid="ignore", divide="ignore"):
            shares = ((trial.got("result") - kr) / (1 - kr))[:, 0]
        if len(np.unique(np.round(shares[np.isfinite(shares)] / STEP))) < SHARES:
            trial.expect("result")
    check_results(student, suite)
