"""JupyterLab in a real browser, with a notebook of the bench that has run."""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path

from playwright.sync_api import Error

from grader.authoring.bench.browser import BrowserSession, NoJupyter, session, write
from grader.authoring.bench.programs import BenchError


@contextlib.contextmanager
def notebook(place: Path, cells: Sequence[str]) -> Iterator[BrowserSession]:
    """Open a notebook of these cells in a folder made anew, and run them.

    Raises NoBrowser where none can be driven, BenchError where JupyterLab or a page stays silent.
    """
    shutil.rmtree(place, ignore_errors=True)
    write(place / "project", cells)
    (place / "home").mkdir()
    try:
        with session(place / "project", place / "home") as opened:
            opened.run_all()
            yield opened
    except (NoJupyter, Error) as error:
        raise BenchError(f"{str(error).splitlines()[0]}; see {place / 'home' / 'log'}") from None
