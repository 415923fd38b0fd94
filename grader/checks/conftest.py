"""`pytest grader/checks --submission PATH`: the checks alone, with pytest's own report.

Under `python -m grader` the plugin is there already, and nothing happens here.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from grader.checking import expected_data
from grader.checking.student import SIZES
from grader.course import exercises
from grader.course.texts import Texts, preferred
from grader.evaluation.plugin import GraderPlugin
from grader.execution.libraries import Libraries
from grader.intake.submission import read_submission


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the options of a run without the command line."""
    group = parser.getgroup("grader")
    group.addoption("--submission", type=Path, default=exercises.CORE, metavar="PATH")
    group.addoption("--expected", type=Path, default=expected_data.FOLDER, metavar="DIR")


def pytest_configure(config: pytest.Config) -> None:
    """Build the submission and hand it to the checks, unless the command line has done so."""
    if any(isinstance(each, GraderPlugin) for each in config.pluginmanager.get_plugins()):
        return
    submission = read_submission(config.getoption("submission"))
    cache = exercises.ROOT / "build" / "cache"
    libraries = Libraries(submission, SIZES, cache)
    config.add_cleanup(libraries.close)
    folder = config.getoption("expected")
    plugin = GraderPlugin(libraries, exercises.load(), None, folder, Texts(preferred()))
    config.pluginmanager.register(plugin, "grader")
