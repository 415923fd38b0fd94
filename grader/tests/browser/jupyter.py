"""JupyterLab on a student's folder, with a browser on it, for the tests."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path

from grader.authoring.bench import browser
from grader.authoring.bench.browser import NOTEBOOK, BrowserSession, write
from grader.tests.browser.chromium import wanted

__all__ = ["DOT", "BrowserSession", "session", "write"]

DOT = "float n_l = vector_dot(n, l);"  # a line of the C file


@contextlib.contextmanager
def session(
    project: Path, home: Path, prefix: str = "/", notebook: str = NOTEBOOK
) -> Iterator[BrowserSession]:
    """Start JupyterLab and a browser, or skip the test: see grader/authoring/jupyter.py."""
    with wanted(), browser.session(project, home, prefix, notebook) as made:
        yield made
