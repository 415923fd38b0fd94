"""A notebook opened again, without the kernel in which it was run."""

from __future__ import annotations

from pathlib import Path

import pytest

from grader.tests.browser import jupyter
from grader.tests.browser.chromium import screenshot

CELLS = [
    "from grader.lab import Core, inspect, predict, slider\ncore = Core()\n"
    "slider(lambda j: core.render(scene=0, size=(96, 64)), j=(0, 5))",
    'predict("tp1.first_pixel", "ABC")',
    "inspect(0, (160, 60))",
]
SHOWN = (".jupyter-widgets img", "button:text-is('B')", ".mrt-told[data-pixel='160,60']")
# The notebook's tab has no dot any more.
SAVED = "() => !document.querySelector('.lm-TabBar-tab.jp-mod-dirty')"


@pytest.mark.exhaustive
def test_widgets_are_there_the_next_day(tmp_path: Path) -> None:
    """A slider with its picture, the buttons of a prediction, an inspector: as they were saved."""
    project, home = tmp_path / "projet", tmp_path / "jupyter"
    jupyter.write(project, CELLS)
    for evening in (True, False):
        with jupyter.session(project, home) as session:
            if evening:
                session.run_all()
            for cell, what in enumerate(SHOWN):
                session.output(cell).locator(what).wait_for()
            screenshot(session.page, f"day-{evening}")
            assert "Error displaying" not in session.page.inner_text(".jp-Notebook")
            assert session.complaints == []
            if evening:
                session.page.keyboard.press("Control+s")
                session.page.wait_for_function(SAVED)
