"""The suites: how each is made, and the file that one becomes."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterator, Sequence
from dataclasses import replace
from types import ModuleType
from typing import Any

from grader.authoring.expected import vectors
from grader.authoring.expected.vectors.maker import Recipe, Suite
from grader.checking.expected_data import Batch, encode
from grader.execution.session import Library, Limits


def parts() -> Iterator[ModuleType]:
    """Yield the modules of vectors/ that make suites: those with recipes()."""
    for each in pkgutil.iter_modules(vectors.__path__, f"{vectors.__name__}."):
        module = importlib.import_module(each.name)
        if hasattr(module, "recipes"):
            yield module


def recipes() -> list[Recipe]:
    """Return how every suite is made."""
    return [each for part in parts() for each in part.recipes()]


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
