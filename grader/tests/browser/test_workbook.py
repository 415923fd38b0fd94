"""Whole notebooks of the workbook in JupyterLab: in either theme, at any width and zoom."""

from __future__ import annotations

from pathlib import Path

import pytest

from grader.authoring.workbook.notebooks import LANGUAGES
from grader.course import exercises
from grader.lab.__main__ import SETTINGS
from grader.lab.display import store
from grader.tests.browser import jupyter
from grader.tests.browser.chromium import screenshot
from grader.tests.browser.jupyter import BrowserSession
from grader.tests.browser.looks import BEYOND, CONTRAST, LINES, TEXT, THEMES, turn

EACH = [f"{language}/TP{tp}" for tp in sorted(exercises.load().tps) for language in LANGUAGES]
TRACKER = "@jupyterlab/notebook-extension/tracker"
HEIGHT = 900
RUN_SECONDS = 900  # for a whole notebook, on a loaded machine
# A window's width, and the browser's zoom: a page has the one divided by the other.
WINDOWS = [(width, zoom) for width in (1280, 390) for zoom in (1, 2)]
SETTLED = 1000  # milliseconds, for what has another width to be drawn
SCROLL = "(share) => { const all = document.querySelector('.jp-WindowedPanel-outer');"
SCROLL += " all.scrollTop = share * all.scrollHeight; }"


def whole(home: Path) -> None:
    """Let JupyterLab draw all cells, not only what is near."""
    path = home / "settings" / f"{TRACKER}.jupyterlab-settings"
    store.write_json(path, {**SETTINGS[TRACKER], "windowingMode": "none"})


def faults(session: BrowserSession, name: str, theme: str, width: int, zoom: int) -> list[str]:
    """Return what cannot be read, or goes beyond the edge, in a window of that width and zoom."""
    page = session.page
    page.set_viewport_size({"width": width // zoom, "height": HEIGHT // zoom})
    page.wait_for_timeout(SETTLED)
    for share in (0, 0.3, 0.6, 0.9):
        page.evaluate(SCROLL, share)
        kind = theme.split()[-1].lower()
        screenshot(page, f"{name.replace('/', '-')}-{kind}-{width}-{zoom}-{share}")
    found = page.evaluate(CONTRAST)
    assert len(found["texts"]) > 100
    pale = [each for each in found["texts"] if each[0] < TEXT]
    pale += [each for each in found["lines"] if each[0] < LINES]
    where = f"{theme}, {width} px, {zoom}00 %"
    return [f"{where}: {each}" for each in (*pale, *page.evaluate(BEYOND))]


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", EACH)
def test_a_whole_notebook_can_be_read(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Run whole: contrasts of 4.5 and 3, no scroll bar below anything, no error in the console."""
    monkeypatch.setenv("MRT_LANG", name.partition("/")[0])
    project, home, notebook = tmp_path / "projet", tmp_path / "jupyter", f"notebooks/{name}.ipynb"
    jupyter.write(project, notebook=notebook)
    whole(home)
    with jupyter.session(project, home, notebook=notebook) as session:
        session.run_all(RUN_SECONDS)
        session.page.keyboard.press("Control+Shift+D")  # the notebook alone
        found = []
        for theme in THEMES:
            session.page.set_viewport_size({"width": 1280, "height": HEIGHT})  # for the menu
            turn(session.page, theme)
            for width, zoom in WINDOWS:
                found += faults(session, name, theme, width, zoom)
        assert found == []
        assert session.complaints == []
