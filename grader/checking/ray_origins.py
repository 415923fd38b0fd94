"""What is accepted of a ray that bounces off, or goes through, a surface.

Its origin is moved off the surface, along the ray or along the normal, or else its tmin keeps it
off: every way that keeps a surface from meeting itself.
"""

from __future__ import annotations

import numpy as np

from grader.checking.comparison import Answers, unit
from grader.checking.expected_data import Array

# Scene units; the course's epsilon is 1e-4.
LEAST, MOST = 5e-6, 5e-3
# A ray that leaves sees at least that far.
FAR = 100.0


def expect_origin(trial: Answers, where: Array) -> None:
    """Raise Wrong unless the rays in `out` start at the point hit, a little off the surface."""
    got = trial.answer.out["out"]
    position, normal = (trial.batch.args["it"][name] for name in ("position", "normal"))
    way = unit(got["dir"])
    side = np.sign(np.einsum("ij,ij->i", way, normal))[:, None] * normal
    with np.errstate(invalid="ignore", over="ignore"):
        moved = got["orig"].astype(np.float64) - position
        length = np.linalg.norm(moved, axis=1)
        slack = 0.1 * length + 2e-6
        ways = [np.linalg.norm(moved - length[:, None] * each, axis=1) for each in (way, side)]
        along = (ways[0] <= slack) | (ways[1] <= slack)
        start = np.where(got["tmin"] <= MOST, got["tmin"], 0)
        off = (np.maximum(length, start) >= LEAST) & (length <= MOST)
    wrong = ~(along & off) & where
    trial.observations.note(f"{trial.name} out.orig", got["orig"], wrong, trial.batch.tolerance)
    trial.complain(wrong, "failure.origin", got=got["orig"], position=position, what="out->orig")


def expect_fresh(trial: Answers, where: Array) -> None:
    """Raise Wrong unless the rays in `out` have a range of their own: from near 0 to far."""
    got = trial.answer.out["out"]
    for name, right, expected in (
        ("tmin", (got["tmin"] >= 0) & (got["tmin"] <= MOST), 0),
        ("tmax", got["tmax"] >= FAR, 1000),
    ):
        wrong = ~right & where
        values = {"got": got[name], "expected": expected}
        trial.complain(wrong, "failure.output", what=f"out->{name}", **values)
