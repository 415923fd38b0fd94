"""A lab session in JupyterLab itself: notebook and C file side by side, in a real browser."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from grader.tests.browser import jupyter
from grader.tests.browser.chromium import screenshot
from grader.tests.browser.jupyter import DOT, Session

CELLS = (
    "from grader.lab import Core, check, predict, slider\n\ncore = Core()\ncore.size = (160, 90)",
    "slider(lambda k: core.render(scene=k), k=[0, 4])",
    'predict("tp2.side", "AB")',
    "core.render(scene=0)",
    'check("TP1.1")',
)
SLIDER, PICTURE, LAST = 1, 3, 4


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Session]:
    """Start JupyterLab on a short notebook, and a browser on it."""
    project = tmp_path_factory.mktemp("projet")
    jupyter.write(project, CELLS)
    with jupyter.session(project, tmp_path_factory.mktemp("jupyter")) as made:
        yield made


def test_a_lab_session(session: Session) -> None:
    """Side by side; run all; a slider; a broken file; mended; a crash; and nothing complains."""
    page = session.page
    assert page.locator(".jp-FileEditor").is_visible()
    session.run_all()
    before = session.picture(PICTURE)
    assert "right, 2 / 2" in session.output(LAST).inner_text()
    screenshot(page, "lab-run")

    slow = session.picture(SLIDER)
    handle = session.output(SLIDER).locator(".noUi-handle")
    handle.focus()
    page.keyboard.press("ArrowRight")
    page.wait_for_function(
        "([cell, old]) => { const image = document.querySelectorAll('.jp-Notebook .jp-Cell')[cell]"
        ".querySelector('.jp-OutputArea img'); return image && image.src !== old; }",
        arg=[SLIDER, slow],
    )
    screenshot(page, "lab-slider")

    session.output(2).locator("button:text-is('B')").click()

    session.edit(DOT, DOT.replace(";", ""))
    session.run_all()
    told = session.output(PICTURE).inner_text()
    assert "error: expected" in told
    assert "^" in told
    assert "Traceback" not in page.inner_text(".jp-Notebook")
    screenshot(page, "lab-broken")
    session.output(PICTURE).locator("a").first.click()
    page.wait_for_function(
        "() => [...document.querySelectorAll('.jp-FileEditor .cm-line')]"
        ".some((line) => line.innerText.includes('float n_l'))"
    )
    screenshot(page, "lab-link")

    session.edit(DOT.replace(";", ""), DOT)
    session.run_all()
    assert session.picture(PICTURE) == before

    session.edit(DOT, f"{DOT} volatile int *p = 0; *p = 1;")
    session.run_all()
    assert "in shade (raytracer.c:" in session.output(PICTURE).inner_text()
    assert "right, 2 / 2" in session.output(LAST).inner_text()  # the cells behind it have run
    screenshot(page, "lab-crash")
    kept = session.output(2).locator("button.mod-active").inner_text()
    assert kept.strip() == "B"
    assert session.complaints == []
