"""The solver without an idea, as a folder that is handed in."""

from __future__ import annotations

from pathlib import Path

from grader.authoring.proof import solver
from grader.authoring.proof.solver import TURNS

__all__ = ["TURNS", "stub"]


def stub(folder: Path, turn: int) -> None:
    """Write a submission in which each function tries one of its attempts."""
    for file, content in solver.files(turn).items():
        (folder / file).write_text(content, encoding="utf-8")
