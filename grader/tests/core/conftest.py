"""What the tests of the core share: sessions of the reference, and random worlds."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from grader.course.exercises import ROOT
from grader.execution.session import Library, Session, open_core

SEED = 20_261_122


@pytest.fixture
def s(reference: Library) -> Iterator[Session]:
    """Return a session of the reference, in both builds."""
    with reference.session() as session:
        yield session


@pytest.fixture(scope="session")
def scenes(cache: Path) -> Iterator[Library]:
    """Return the reference at 160x90, optimised."""
    with open_core(ROOT / "reference", 160, 90, cache=cache) as core:
        yield core


@pytest.fixture
def rng() -> np.random.Generator:
    """Return random numbers, the same for every test."""
    return np.random.default_rng(SEED)
