"""A lab session in JupyterLab itself: TP2's notebook and the C file side by side, in a browser."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from grader.authoring.bench.slider import STEP
from grader.tests.browser import jupyter
from grader.tests.browser.chromium import screenshot
from grader.tests.browser.jupyter import BrowserSession

LINE = "vec3 from_center = vector_minus(r->orig, obj->center);"  # of intersect_sphere
CRASH = f"{LINE} *(volatile int *)0 = 1;"
# How the cells of TP2's notebook begin that this session looks at.
SLIDER = "slider(tp2.sphere_curve"
FIGURE = "picture = core.render(scene=0"  # and a comparison with figure 4
PREDICTION = 'predict("tp2.tests_of_a_pixel"'
CHECK = 'check("TP2.6")'


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Iterator[BrowserSession]:
    """Start JupyterLab on a copy of the workbook's TP2, finished, and a browser on it."""
    project = tmp_path_factory.mktemp("projet")
    jupyter.write(project)
    with jupyter.session(project, tmp_path_factory.mktemp("jupyter")) as made:
        yield made


@pytest.mark.exhaustive
def test_a_lab_session(session: BrowserSession) -> None:
    """Side by side; run all; a slider; a broken file; mended; a crash; and nothing complains."""
    page = session.page
    assert page.locator(".jp-FileEditor").is_visible()
    session.run_all()
    show(session, session.cell(CHECK), "lab-run")
    session.told(session.cell(CHECK), "right, 5 / 5")
    assert "○" not in page.inner_text(".jp-Notebook")

    slider = session.cell(SLIDER)
    slow = session.picture(slider)
    session.output(slider).locator(".noUi-handle").first.focus()
    page.keyboard.press("ArrowRight")
    session.wait_for_another_picture(slider, slow)
    assert page.evaluate(STEP, slider) > 0  # as `make bench` does
    show(session, slider, "lab-slider")

    session.output(session.cell(PREDICTION)).locator("button:text-is('B')").click()
    breaks_and_mends(session)
    session.run(session.cell(PREDICTION))
    kept = session.output(session.cell(PREDICTION)).locator("button.mod-active").inner_text()
    assert kept.strip() == "B"
    assert session.complaints == []


def breaks_and_mends(session: BrowserSession) -> None:
    """Save a file that does not compile, then the right one, then one that crashes."""
    page, figure = session.page, session.cell(FIGURE)
    before = session.picture(figure)
    session.edit(LINE, LINE.replace(";", ""))
    session.run(figure)
    assert "^" in session.told(figure, "error: expected")
    assert "Traceback" not in page.inner_text(".jp-Notebook")
    show(session, figure, "lab-broken")
    session.output(figure).locator("a").first.click()
    page.wait_for_function(
        "() => [...document.querySelectorAll('.jp-FileEditor .cm-line')]"
        ".some((line) => line.innerText.includes('vec3 from_center'))"
    )
    screenshot(page, "lab-link")

    session.edit(LINE.replace(";", ""), LINE)
    session.run(figure)
    assert session.picture(figure) == before

    session.edit(LINE, CRASH)
    session.run(figure)
    session.told(figure, "in intersect_sphere (raytracer.c:")
    show(session, figure, "lab-crash")
    session.run(session.cell(CHECK))  # the kernel lives: what stands behind works
    session.told(session.cell(CHECK), "look there")  # alone, it blames nobody else for certain


def show(session: BrowserSession, cell: int, name: str) -> None:
    """Scroll to what a cell shows, and keep what the page looks like."""
    session.output(cell).scroll_into_view_if_needed()
    screenshot(session.page, name)
