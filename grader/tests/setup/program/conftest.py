"""The programs that several tests run, each built once."""

from __future__ import annotations

from pathlib import Path

import pytest

from grader.course.exercises import CORE
from grader.tests.setup.program.program import (
    HEIGHT,
    REFERENCE,
    WATCHED,
    WIDTH,
    build_mrt,
    make_mrt,
    need_sanitizers,
    size_flags,
)


@pytest.fixture(scope="session")
def mrt(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the reference's program, as `make mrt` builds it, in a folder with an accent."""
    folder = tmp_path_factory.mktemp("été")
    return make_mrt(folder, "reference", WIDTH=str(WIDTH), HEIGHT=str(HEIGHT))


@pytest.fixture(scope="session")
def skeleton_mrt(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the skeleton's program, small."""
    folder = tmp_path_factory.mktemp("skeleton") / "mrt"
    return build_mrt(folder, ["-O1", "-g", *size_flags(160, 90)], CORE)


@pytest.fixture(scope="session")
def watched_mrt(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the reference's program at 160x90 under the sanitizers."""
    folder = tmp_path_factory.mktemp("watched")
    need_sanitizers(folder)
    return build_mrt(folder / "mrt", [*WATCHED, *size_flags(160, 90)], CORE, REFERENCE)
