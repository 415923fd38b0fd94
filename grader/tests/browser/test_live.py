"""live() in JupyterLab, behind a prefix as JupyterHub has: a saved file is seen at once."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from grader.tests.browser import jupyter
from grader.tests.browser.chromium import screenshot
from grader.tests.browser.jupyter import DOT, BrowserSession

pytestmark = pytest.mark.long

CELLS = ["from grader.lab import live\n\nlive(0, shadows=False)", "live(0)"]
PHONE = {"width": 420, "height": 800}
IMAGE = ".mrt-live img"


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Iterator[BrowserSession]:
    """Start JupyterLab on a notebook of two cells, and a browser on it."""
    project = tmp_path_factory.mktemp("projet")
    jupyter.write(project, CELLS)
    with jupyter.session(project, tmp_path_factory.mktemp("jupyter"), "/user/someone/") as made:
        yield made


def test_a_saved_file_is_seen(session: BrowserSession) -> None:
    """Picture, verdict, compiler's line, and the inspector by a click; no cell is run again."""
    page, area = session.page, session.output(0)
    session.run_all()
    area.get_by_text("Run its cell again").wait_for()  # one follows at a time: the last
    session.run(0)
    area.get_by_text("Drawn at").wait_for()
    session.output(1).get_by_text("Run its cell again").wait_for()
    right, other = session.picture(0), session.picture(1)
    screenshot(page, "live-open")

    session.edit(DOT, DOT.replace("vector_dot(n, l)", "-vector_dot(n, l)"))
    area.get_by_text("shade: to review").first.wait_for()
    wrong = session.picture(0)
    assert wrong != right
    assert session.picture(1) == other
    screenshot(page, "live-wrong")

    session.edit("-vector_dot(n, l);", "-vector_dot(n, l)")
    area.get_by_text("does not compile yet").wait_for()
    assert "raytracer.c:" in area.inner_text()
    assert session.picture(0) == wrong  # the last one stays
    screenshot(page, "live-error")

    session.edit("-vector_dot(n, l)", "vector_dot(n, l);")
    area.get_by_text("shade: right").first.wait_for()
    assert session.picture(0) == right

    page.locator(IMAGE).first.click(position={"x": 320, "y": 180})
    area.locator(".mrt-told[data-pixel^='160,']").wait_for()
    page.set_viewport_size(PHONE)
    wide = "(each) => each.scrollWidth <= each.clientWidth + 1"
    assert page.locator(".mrt-live").first.evaluate(wide)
    screenshot(page, "live-inspector")
    assert session.complaints == []
