"""What judging one picture costs: reading what is accepted, and measuring; not drawing it."""

from __future__ import annotations

import statistics
import time
from collections.abc import Iterable
from dataclasses import dataclass

from grader.authoring.expected.pictures.readings import REFERENCE
from grader.authoring.expected.pictures.texels import texels
from grader.checking.expected_data import FOLDER
from grader.checking.pictures.judgement import judge
from grader.checking.pictures.plan import judged

ROUNDS = 9
GOAL_MS = 5.0


@dataclass(frozen=True)
class JudgedPicture:
    """A picture, and the milliseconds of CPU that its judgement took, the median."""

    name: str
    milliseconds: float


def measure() -> list[JudgedPicture]:
    """Judge the reference's own pictures."""
    found = []
    for picture in judged():
        drawn = REFERENCE.draw(picture, texels(), seed=1 if picture.stage == "glass" else 0)
        judge(FOLDER, picture, drawn)  # reads the manifest
        costs = []
        for _ in range(ROUNDS):
            start = time.process_time()
            judge(FOLDER, picture, drawn)
            costs.append(1000 * (time.process_time() - start))
        found.append(JudgedPicture(picture.name, statistics.median(costs)))
    return found


def text(judged: Iterable[JudgedPicture]) -> str:
    """Return a line: the mean and the worst, and whether each is within the goal."""
    costs = {each.name: each.milliseconds for each in judged}
    worst = max(costs, key=lambda name: costs[name])
    return (
        f"Judging one picture: {statistics.mean(costs.values()):.1f} ms of CPU on the mean, "
        f"{costs[worst]:.1f} at most ({worst}); goal {GOAL_MS:g}: "
        f"{'yes' if costs[worst] <= GOAL_MS else 'MISSED'}"
    )
