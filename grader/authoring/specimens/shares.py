"""Shares of an exercise's points that a teacher takes off: from the least to the most."""

from __future__ import annotations

from collections.abc import Collection

from grader.course.exercises import Exercise

Range = tuple[float, float]


def span(values: object) -> Range:
    """Return the least and the most of a share. Raises ValueError, TypeError."""
    least, most = (float(each) for each in values)  # type: ignore[attr-defined]
    if not 0 <= least <= most <= 1:
        raise ValueError(f"a share is [least, most], from 0 to 1, not {values}")
    return least, most


def told(share: Range) -> str:
    """Return a range in words."""
    return f"{share[0]:.0%} to {share[1]:.0%}"


def of_functions(exercise: Exercise, failing: Collection[str]) -> float:
    """Return the share of an exercise's points that failing checks of its functions cost.

    What has a twin among them earns nothing either; what pictures lose comes on top.
    """
    lost = [each for each in exercise.checks if each.id in failing or each.twin in failing]
    return sum(each.points for each in lost) / sum(each.points for each in exercise.checks)
