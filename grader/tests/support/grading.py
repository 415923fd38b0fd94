"""Running `python -m grader grade` in a process of its own, with builds that are kept."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from grader.course.exercises import ROOT
from grader.tests.support.outputs import outputs

SECONDS = 180  # a grade that takes longer is stuck


class Graded:
    """What a run printed and wrote."""

    def __init__(self, done: subprocess.CompletedProcess[str], results: Path) -> None:
        self.code, self.out, self.err = done.returncode, done.stdout, done.stderr
        self.results: dict[str, Any] = {}
        if results.exists():
            self.results = json.loads(results.read_text(encoding="utf-8"))

    def points(self) -> dict[str, float]:
        """Return the points of each check that earned some, by its id without "tp1."."""
        checks = self.results["checks"]
        return {each["id"][4:]: each["points"] for each in checks if each["points"]}

    def outcomes(self) -> dict[str, str]:
        """Return the outcome of each exercise by its function."""
        return {each["function"]: each["outcome"] for each in self.results["exercises"]}

    def check(self, name: str) -> dict[str, Any]:
        """Return one check by its id without "tp1."."""
        (found,) = (each for each in self.results["checks"] if each["id"] == f"tp1.{name}")
        return dict(found)


def grade(
    folder: Path,
    build: Path,
    cache: Path,
    *words: str,
    settings: Mapping[str, str],
    root: Path = ROOT,
) -> Graded:
    """Grade a folder by the grader in `root`; `settings` are environment variables.

    Outputs go to `build`, where a TP or a keyword among the words makes it a partial run.
    """
    outputs(build, cache)
    environment = {k: v for k, v in os.environ.items() if k not in ("MRT_LANG", "CC")}
    command = [sys.executable, "-m", "grader", "grade", str(folder), "--build", str(build), *words]
    done = subprocess.run(
        command,
        cwd=root,
        env={**environment, **settings},
        capture_output=True,
        text=True,
        timeout=SECONDS,
        check=False,
    )
    part = "partial" if "-k" in words or "--tp" in words else ""
    return Graded(done, build / "grade" / part / "results.json")
