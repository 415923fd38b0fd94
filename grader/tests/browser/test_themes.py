"""What cells show, in JupyterLab's light and dark themes and on a narrow screen: it can be read."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from grader.tests.browser import jupyter
from grader.tests.browser.chromium import screenshot
from grader.tests.browser.jupyter import DOT, BrowserSession

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
WIDE, PHONE = {"width": 1400, "height": 1000}, {"width": 390, "height": 800}
TEXT, LINES = 4.5, 3.0  # the least contrasts, of WCAG 2.1
THEMES = ("JupyterLab Light", "JupyterLab Dark")
# Whether the notebook stands on dark ground.
GROUND = """(dark) => { const style = getComputedStyle(document.querySelector(".jp-Notebook"));
  return parseInt(style.backgroundColor.slice(4)) < 64 === dark; }"""
# The contrasts of the texts of the outputs that are drawn, and of the lines beside them.
CONTRAST = """() => {
  const paint = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
  const rgba = (color) => {
    paint.clearRect(0, 0, 1, 1);
    paint.fillStyle = color;
    paint.fillRect(0, 0, 1, 1);
    const [r, g, b, a] = paint.getImageData(0, 0, 1, 1).data;
    return a ? [r, g, b, a / 255] : [0, 0, 0, 0];
  };
  const over = ([r, g, b, a], below) => [r, g, b].map((each, k) => a * each + (1 - a) * below[k]);
  const ground = (node) => {
    if (!node) return [255, 255, 255];
    const own = rgba(getComputedStyle(node).backgroundColor);
    return own[3] === 1 ? own.slice(0, 3) : over(own, ground(node.parentElement));
  };
  const light = (color) => {
    const [r, g, b] = color.map((each) => each / 255)
      .map((each) => (each <= 0.03928 ? each / 12.92 : ((each + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const contrast = (one, other) => {
    const [low, high] = [light(one), light(other)].sort((a, b) => a - b);
    return (high + 0.05) / (low + 0.05);
  };
  const texts = [], lines = [];
  for (const each of document.querySelectorAll(".jp-OutputArea-output *")) {
    const style = getComputedStyle(each);
    const below = ground(each);
    const own = [...each.childNodes].filter((child) => child.nodeType === 3);
    const words = own.map((child) => child.textContent).join("").trim();
    if (words && each.tagName !== "STYLE" && each.offsetParent) {
      texts.push([contrast(over(rgba(style.color), below), below), words.slice(0, 40)]);
    }
    if (parseFloat(style.borderLeftWidth) >= 1 && each.tagName !== "BUTTON" && each.offsetParent) {
      const edge = over(rgba(style.borderLeftColor), ground(each.parentElement));
      lines.push([contrast(edge, ground(each.parentElement)), each.outerHTML.slice(0, 80)]);
    }
  }
  const drawn = (each, what) => { // a colour of a drawing, as it is seen on what is below
    const style = getComputedStyle(each);
    const color = style[what].startsWith("rgb") ? rgba(style[what]) : [0, 0, 0, 0];
    return [...color.slice(0, 3), color[3] * style[`${what}Opacity`] * style.opacity];
  };
  const below = (word) => { // what a word of a drawing stands on
    word.scrollIntoView({ block: "center" });
    const box = word.getBoundingClientRect();
    const found = document.elementsFromPoint(box.x + box.width / 2, box.y + box.height / 2)
      .filter((each) => each.closest(".mrt-drawing g") && !each.closest(".mrt-text"));
    return found.reverse().reduce((color, each) => over(drawn(each, "fill"), color), ground(word));
  };
  for (const each of document.querySelectorAll(".mrt-drawing .mrt-text")) {
    const behind = below(each), ink = drawn(each.querySelector("use, path:not(defs *)"), "fill");
    texts.push([contrast(over(ink, behind), behind), each.outerHTML.slice(0, 200)]);
  }
  for (const each of document.querySelectorAll(".mrt-drawing .mrt-line2d path:not(defs *)")) {
    const line = drawn(each, "stroke"), behind = ground(each);
    if (line[3] && !each.closest(".mrt-axes").querySelector("image")) {
      lines.push([contrast(over(line, behind), behind), each.outerHTML.slice(0, 80)]);
    }
  }
  return { texts, lines };
}"""
# Whether the view in space has a dark ground, and white among what is drawn there.
SPACE = """(dark) => {
  const canvas = document.querySelector(".mrt-space");
  const ground = parseInt(getComputedStyle(canvas).backgroundColor.slice(4));
  const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
  let most = 0; // of red, in what is not transparent
  for (let k = 0; k < data.length; k += 4) if (data[k + 3] === 255) most = Math.max(most, data[k]);
  return ground < 64 === dark && most > 240 === dark;
}"""
# What goes beyond the screen's right edge, of the page, of the notebook and of the outputs.
BEYOND = """() => [...document.querySelectorAll(
  "html, .jp-OutputArea-output, .jp-OutputArea-output .mrt-inspector, .jp-OutputArea-output table")]
  .filter((each) => each.scrollWidth > each.clientWidth + 1
    || each.getBoundingClientRect().right > window.innerWidth + 1)
  .map((each) => each.outerHTML.slice(0, 100))"""


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Iterator[BrowserSession]:
    """Start JupyterLab on a notebook of what cells show, one of its checks failing."""
    project = tmp_path_factory.mktemp("projet")
    jupyter.write(project, CELLS)
    with jupyter.session(project, tmp_path_factory.mktemp("jupyter")) as made:
        made.edit(DOT, f"{DOT} n_l = -n_l;")
        made.run_all()
        yield made


def turn(page: Any, theme: str) -> None:
    """Choose a theme in the menu, as a person does."""
    page.click(".lm-MenuBar-itemLabel:text-is('Settings')")
    page.hover(".lm-Menu-itemLabel:text-is('Theme')")
    page.click(f".lm-Menu-itemLabel:text-is('{theme}')")
    page.wait_for_function(GROUND, arg="Dark" in theme)


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


def test_a_narrow_screen_needs_no_scroll_bar(session: BrowserSession) -> None:
    """At 390 pixels, the notebook alone: nothing that a cell shows is wider than the screen."""
    page = session.page
    turn(page, THEMES[0])
    page.set_viewport_size(PHONE)
    page.keyboard.press("Control+Shift+D")  # one document at a time
    page.wait_for_timeout(1000)
    page.locator(".mrt-inspector").scroll_into_view_if_needed()
    screenshot(page, "phone")
    found = page.evaluate(BEYOND)
    page.keyboard.press("Control+Shift+D")
    page.set_viewport_size(WIDE)
    assert found == []
