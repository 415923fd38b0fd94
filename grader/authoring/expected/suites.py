"""The suites: how each is made, and the file that one becomes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from grader.authoring.expected.vectors import glass, mirrors, octree, patterns, tp2, tp3, tp4, tp5
from grader.authoring.expected.vectors.maker import Recipe, Suite
from grader.checking.expected_data import Batch, encode
from grader.execution.session import Library, Limits

PARTS = (tp2, tp3, patterns, tp4, mirrors, octree, tp5, glass)


def recipes() -> list[Recipe]:
    """Return how every suite is made, in the order of the TPs."""
    return [each for part in PARTS for each in part.recipes()]


def suites(core: Library, seed: int, chosen: Sequence[Recipe] | None = None) -> list[Suite]:
    """Return suites of a seed, all unless some are chosen, with the answers of the reference."""
    made = []
    for recipe in recipes() if chosen is None else chosen:
        # A session of its own: no suite depends on what another one has left behind.
        with core.session(Limits(cpu=60)) as session:
            made.append(recipe.suite(core, session, seed))
    return made


def batches_of(suite: Suite) -> list[Batch]:
    """Return the calls of a suite, as its file holds them."""
    return [replace(each.batch, tolerance=suite.tolerance) for each in suite.questions]


def file_of(suite: Suite) -> tuple[dict[str, bytes], dict[str, Any]]:
    """Return the file of a suite by its name, and what the manifest says of it."""
    batches = batches_of(suite)
    return {f"{suite.name}.npz": encode(batches)}, {
        "calls": sum(each.count for each in batches),
        "tolerance": suite.tolerance,
        "reason": suite.reason,
    }
