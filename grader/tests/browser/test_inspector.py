"""The pixel inspector in JupyterLab, behind a JupyterHub-like prefix, in a real browser."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import pytest

from grader.tests.browser import jupyter
from grader.tests.browser.chromium import screenshot
from grader.tests.browser.jupyter import DOT, BrowserSession

PREFIX = "/user/someone/"  # as JupyterHub gives each person
CELLS = ["from grader.lab import check, inspect\n\ninspect(0, (160, 60))", 'check("TP3.2")']
LIGHT = "lights[k].col, &it->mat));"  # of direct_light
WIDE = (1400, 1000)
PHONE, ZOOMED = (420, 800), (700, 500)  # the last: 200 % of the usual one


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Iterator[BrowserSession]:
    """Start JupyterLab behind the prefix, on a notebook of two cells, and a browser on it."""
    project = tmp_path_factory.mktemp("projet")
    jupyter.write(project, CELLS)
    with jupyter.session(project, tmp_path_factory.mktemp("jupyter"), PREFIX) as made:
        yield made


def _size(pair: tuple[int, int]) -> dict[str, int]:
    return {"width": pair[0], "height": pair[1]}


def _wait_pixel(page: Any, i: int, j: int) -> None:
    """Wait until the table is that of a pixel."""
    page.wait_for_selector(f".mrt-told[data-pixel='{i},{j}']")


def _drawn(page: Any) -> str:
    """Return what the view in space shows, as data."""
    return str(page.evaluate("() => document.querySelector('.mrt-space').toDataURL()"))


@pytest.mark.long
def test_the_inspector_at_work(session: BrowserSession) -> None:
    """Click, keys, zoom, orbit, linked rows; a crash and its mending; small windows; no error."""
    page = session.page
    session.run_all()
    _wait_pixel(page, 160, 60)
    screenshot(page, "inspector-open")

    picture = page.locator(".mrt-picture")
    picture.click(position={"x": 90.5, "y": 180 - 50 - 0.5})
    _wait_pixel(page, 90, 50)
    assert "the red sphere" in page.locator(".mrt-told").inner_text()
    page.keyboard.press("ArrowRight")
    _wait_pixel(page, 91, 50)
    page.keyboard.press("Shift+ArrowUp")
    _wait_pixel(page, 91, 60)
    picture.hover(position={"x": 5.5, "y": 5.5})
    assert page.locator(".mrt-hover").inner_text() == "(5, 174) the sky (0.20, 0.20, 0.60)"
    page.keyboard.press("+")
    assert picture.evaluate("(each) => each.width") == 640
    page.keyboard.press("-")

    _turn(page)
    page.mouse.move(1, 1)  # no row is lit then
    page.wait_for_selector(".mrt-told tr.mrt-lit", state="detached")
    before = _drawn(page)
    page.locator(".mrt-told tr[data-row='0.0']").hover()
    page.wait_for_selector(".mrt-told tr.mrt-lit[data-row='0.0']")
    assert _drawn(page) != before
    screenshot(page, "inspector-lit")

    _break_and_mend(session)
    for size, name in ((PHONE, "phone"), (ZOOMED, "zoomed")):
        page.set_viewport_size(_size(size))
        page.wait_for_timeout(500)
        wide = "(each) => each.scrollWidth <= each.clientWidth + 1"
        assert page.locator(".mrt-inspector").evaluate(wide)
        page.locator(".mrt-inspector").scroll_into_view_if_needed()
        screenshot(page, f"inspector-{name}")
    page.set_viewport_size(_size(WIDE))
    assert session.complaints == []


@pytest.mark.long
def test_from_a_failed_check_to_its_pixel(session: BrowserSession) -> None:
    """One click on what check() shows opens the inspector there: the widget, which then works."""
    page = session.page
    session.edit(LIGHT, f"{LIGHT} sum = vector_clamp(sum, 0.f, 0.2f);")
    session.run(1)
    output = session.output(1)
    told = output.inner_text()
    assert "The first value that goes wrong is the sum of the lights" in told
    found = re.search(r"pixel that is most wrong: \((\d+), (\d+)\)", told)
    assert found is not None
    i, j = found.groups()
    assert output.locator(".mrt-picture").count() == 0
    summary = output.locator("summary").last
    assert summary.inner_text() == f"Open the inspector at pixel ({i}, {j}) of scene0.blinn_phong"
    summary.focus()
    page.keyboard.press("Enter")
    opened = output.locator(f".mrt-told[data-pixel='{i},{j}']")
    opened.wait_for()
    assert "direct_light" in opened.inner_text()
    output.locator(".mrt-picture").focus()
    page.keyboard.press("ArrowRight")  # its processes had ended
    output.locator(f".mrt-told[data-pixel='{int(i) + 1},{j}']").wait_for()
    output.locator(".mrt-inspector").scroll_into_view_if_needed()
    screenshot(page, "inspector-jump")
    assert session.complaints == []


def _turn(page: Any) -> None:
    """Turn the view by dragging and by the keys."""
    space = page.locator(".mrt-space")
    seen = [_drawn(page)]
    box = space.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 60, y + 20)
    page.mouse.up()
    seen.append(_drawn(page))
    space.focus()
    page.keyboard.press("ArrowLeft")
    seen.append(_drawn(page))
    page.keyboard.press("+")
    seen.append(_drawn(page))
    assert len(set(seen)) == len(seen)


def _break_and_mend(session: BrowserSession) -> None:
    """Make it crash: the widget tells the line; after mending, the next pixel works."""
    page = session.page
    session.edit(DOT, f"{DOT} volatile int *p = 0; *p = 1;")
    page.locator(".mrt-picture").focus()
    page.keyboard.press("ArrowLeft")
    _wait_pixel(page, 90, 60)
    told = page.locator(".mrt-told").inner_text()
    assert "your code stops on the way" in told
    assert "in shade (raytracer.c:" in told
    screenshot(page, "inspector-crash")
    session.edit(f"{DOT} volatile int *p = 0; *p = 1;", DOT)
    page.keyboard.press("ArrowLeft")
    _wait_pixel(page, 89, 60)
    assert "Each value of this pixel" in page.locator(".mrt-told").inner_text()
