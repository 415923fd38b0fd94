"""What cells show, in JupyterLab's light and dark themes and on a narrow screen: it can be read."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from grader.tests.browser import jupyter
from grader.tests.browser.chromium import screenshot
from grader.tests.browser.jupyter import DOT, BrowserSession
from grader.tests.browser.looks import BEYOND, CONTRAST, LINES, TEXT, THEMES, turn

pytestmark = pytest.mark.long  # one JupyterLab, started once, for all

CELLS = [
    "from grader.lab import Core, check, compare, help_card, inspect, progress, source\n"
    'source("shade")',
    'check("TP3.2")',
    "help_card()",
    "progress()",
    "core = Core()\ncore.plane((0, 1, 0), 0.2)",
    'img = core.figure("figure_4")\nimg[20:40, 30:60] = 1\ncompare(img, "figure_4")',
    "inspect(0, (160, 60))",
    "from grader.lab import show, slider, tp1, tp2, tp3\n"
    "slider(tp1.distance_map, radius=(1.0, 5.0))",
    "tp2.probe(core)",
    "tp3.lobe()",
    "show(core.image((8, 5)), grid=True)",
]
WIDE = {"width": 1400, "height": 1000}
# Whether the view in space has a dark ground, and white among what is drawn there.
SPACE = """(dark) => {
  const canvas = document.querySelector(".mrt-space");
  const ground = parseInt(getComputedStyle(canvas).backgroundColor.slice(4));
  const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
  let most = 0; // of red, in what is not transparent
  for (let k = 0; k < data.length; k += 4) if (data[k + 3] === 255) most = Math.max(most, data[k]);
  return ground < 64 === dark && most > 240 === dark;
}"""


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Iterator[BrowserSession]:
    """Start JupyterLab on a notebook of what cells show, one of its checks failing."""
    project = tmp_path_factory.mktemp("projet")
    jupyter.write(project, CELLS)
    with jupyter.session(project, tmp_path_factory.mktemp("jupyter")) as made:
        made.edit(DOT, f"{DOT} n_l = -n_l;")
        made.run_all()
        yield made


@pytest.mark.parametrize("theme", THEMES)
def test_what_cells_show_can_be_read(session: BrowserSession, theme: str) -> None:
    """Texts have a contrast of 4.5 with what is behind them, lines of 3; no error is logged."""
    page = session.page
    turn(page, theme)
    texts, lines = [], []
    for cell in range(len(CELLS)):  # JupyterLab draws what is near only
        session.output(cell).scroll_into_view_if_needed()
        screenshot(page, f"theme-{theme.split()[-1].lower()}-{cell}")
        found = page.evaluate(CONTRAST)
        texts += found["texts"]
        lines += found["lines"]
    assert len(texts) > 100
    assert min(texts)[0] >= TEXT, min(texts)
    assert min(lines)[0] >= LINES, min(lines)
    assert session.complaints == []


@pytest.mark.parametrize(("theme", "dark"), [(THEMES[0], False), (THEMES[1], True)])
def test_the_view_in_space_follows_the_theme(
    session: BrowserSession, theme: str, dark: bool
) -> None:
    """Its ground is the page's, and the ray of the eye is light on dark, dark on light."""
    page = session.page
    turn(page, theme)
    page.locator(".mrt-space").scroll_into_view_if_needed()
    page.wait_for_function(SPACE, arg=dark)
    screenshot(page, f"space-{theme.split()[-1].lower()}")


def test_the_handle_of_a_slider_has_a_name(session: BrowserSession) -> None:
    """It is that of what it moves."""
    cell = session.cell("from grader.lab import show")
    session.output(cell).scroll_into_view_if_needed()
    session.output(cell).locator(".noUi-handle[aria-label=radius]").wait_for()


@pytest.mark.parametrize("width", [640, 390, 195], ids=["1280 at 200 %", "390", "390 at 200 %"])
def test_a_narrow_page_needs_no_scroll_bar(session: BrowserSession, width: int) -> None:
    """The notebook alone: nothing that a cell shows is wider than the page, nor is its code."""
    page = session.page
    page.set_viewport_size(WIDE)
    turn(page, THEMES[0])
    page.keyboard.press("Control+Shift+D")  # one document at a time
    page.set_viewport_size({"width": width, "height": 800})
    page.wait_for_timeout(1000)
    found = []
    for cell in range(len(CELLS)):  # JupyterLab draws what is near only
        session.output(cell).scroll_into_view_if_needed()
        screenshot(page, f"narrow-{width}-{cell}")
        found += page.evaluate(BEYOND)
    page.keyboard.press("Control+Shift+D")
    page.set_viewport_size(WIDE)
    assert found == []
