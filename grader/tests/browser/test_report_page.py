"""report.html in a real browser: at a phone's width and on a desk, by keyboard, without script."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from grader.report import page
from grader.tests.browser.chromium import chromium
from grader.tests.support.reports import every_outcome, png

PHONE, TABLET, DESK = (320, 640), (900, 700), (1200, 800)
A4_TEXT = (680, 1009)  # of A4 without its margins, CSS pixels
RED_AND_NAVY = ("red", "navy")  # the pictures of the page


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Start the machine's Chromium."""
    with chromium() as started:
        yield started


@pytest.fixture
def address(tmp_path: Path) -> str:
    """Write the page of a report in which everything happens; return its address."""
    content = every_outcome("fr", tmp_path)
    for each in content["checks"]:
        if each["images"]:
            (tmp_path / each["images"]["got"]).write_bytes(png("red"))
    run = {"graded_at": "2026-03-02T10:30:00+01:00", "score": 1.5, "max_score": 100, "bonus": 0}
    content["history"] = [run, run]
    content["exercises"][0]["part"] = {"run": 2, "of": 12}
    content["exercises"][0]["part"] = {"run": 2, "of": 12}
    path = tmp_path / page.NAME
    path.write_text(page.render(content, tmp_path), encoding="utf-8")
    return path.as_uri()


def opened(browser: Any, address: str, size: tuple[int, int], **settings: Any) -> Any:
    """Open the page; hold, at its end, that it asked for nothing and complained of nothing."""
    viewport = {"width": size[0], "height": size[1]}
    tab = browser.new_page(viewport=viewport, **settings)
    tab.complaints = []
    tab.on("console", lambda message: tab.complaints.append(message.text))
    tab.on("pageerror", lambda error: tab.complaints.append(str(error)))

    def refuse(route: Any) -> None:
        if route.request.url != address:
            tab.complaints.append(route.request.url)
            route.abort()
        else:
            route.continue_()

    tab.route("**/*", refuse)
    tab.goto(address)
    return tab


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("size", [PHONE, TABLET, DESK], ids=["phone", "tablet", "desk"])
def test_nothing_sticks_out(browser: Any, address: str, size: tuple[int, int], scheme: str) -> None:
    """With everything unfolded: no sideways scrolling, no complaint, no request."""
    tab = opened(browser, address, size, color_scheme=scheme)
    tab.click(".all button")
    assert tab.evaluate("[...document.querySelectorAll('.exercise')].every(e => e.open)")
    width = tab.evaluate("document.documentElement.scrollWidth")
    assert (width, tab.complaints) == (size[0], [])
    ground = tab.evaluate("getComputedStyle(document.documentElement).backgroundColor")
    assert (ground == "rgb(255, 255, 255)") is (scheme == "light")
    tab.close()


@pytest.mark.parametrize("size", [PHONE, TABLET, DESK], ids=["phone", "tablet", "desk"])
def test_the_slider_wipes_and_the_pictures_blink(
    browser: Any, address: str, size: tuple[int, int]
) -> None:
    """By keyboard: the arrows move the border; the button takes over, then gives back."""
    tab = opened(browser, address, size)
    tab.click(".all button")
    compare = tab.locator(".compare").first
    slider, button = compare.locator("input"), compare.locator("button")
    top = compare.locator(".stage img").nth(1)
    clip = "element => element.style.clipPath"
    assert top.evaluate(clip) == "inset(0px 0px 0px 50%)"
    slider.focus()
    for _ in range(3):
        tab.keyboard.press("ArrowLeft")
    assert top.evaluate(clip) == "inset(0px 0px 0px 47%)"
    button.focus()
    tab.keyboard.press("Enter")
    assert button.get_attribute("aria-pressed") == "true"
    assert slider.is_disabled()
    tab.wait_for_function("e => e.style.clipPath.includes('100%')", arg=top.element_handle())
    tab.keyboard.press("Enter")
    assert (button.get_attribute("aria-pressed"), slider.is_disabled()) == ("false", False)
    assert top.evaluate(clip) == "inset(0px 0px 0px 47%)"
    assert tab.complaints == []
    tab.close()


def test_exercises_unfold_by_keyboard(browser: Any, address: str) -> None:
    """Tab shows where one is, Enter unfolds; the first stop leads past the contents."""
    tab = opened(browser, address, DESK)
    tab.keyboard.press("Tab")
    assert tab.evaluate("document.activeElement.className") == "skip"
    tab.keyboard.press("Enter")
    assert tab.evaluate("document.activeElement.id") == "main"
    closed = tab.locator(".exercise:not([open])").first
    name = closed.get_attribute("id")
    closed.locator("summary").first.focus()
    tab.keyboard.press("Enter")
    assert tab.evaluate("id => document.getElementById(id).open", name)
    tab.keyboard.press("Shift+Tab")
    tab.keyboard.press("Tab")
    outline = "getComputedStyle(document.activeElement).outlineStyle"
    assert tab.evaluate(outline) == "solid"
    assert tab.complaints == []
    tab.close()


def test_everything_is_there_without_script(browser: Any, address: str) -> None:
    """Exercises unfold, pictures stand side by side, and no dead button is shown."""
    tab = opened(browser, address, DESK, java_script_enabled=False)
    assert tab.locator("button").count() == 0
    assert tab.locator(".compare").count() == 0
    tab.locator(".exercise:not([open]) > summary").first.click()
    pictures = tab.locator(".exercise[open] .side img")
    boxes = [pictures.nth(k).bounding_box() for k in range(2)]
    assert boxes[0]["y"] == boxes[1]["y"]
    assert boxes[0]["x"] < boxes[1]["x"]
    assert tab.complaints == []
    tab.close()


def test_printing_unfolds_and_hides_what_one_cannot_press(browser: Any, address: str) -> None:
    """On paper: what is folded is there, the controls are not."""
    tab = opened(browser, address, DESK)
    tab.emulate_media(media="print")
    tab.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert tab.evaluate("[...document.querySelectorAll('details')].every(e => e.open)")
    for name in ("nav", "button", ".compare", ".reproducer"):
        assert not tab.locator(name).first.is_visible()
    assert tab.locator(".side img").first.is_visible()
    assert tab.complaints == []
    tab.close()


def test_the_page_is_printed_on_a4(browser: Any, address: str) -> None:
    """A few pages that hold the pictures, each of them whole, and no control."""
    tab = opened(browser, address, A4_TEXT)
    tab.emulate_media(media="print")
    tab.evaluate("dispatchEvent(new Event('beforeprint'))")
    shown = tab.locator(".side figure").evaluate_all(
        "all => all.map(e => [getComputedStyle(e).breakInside, e.clientWidth, e.clientHeight])"
    )
    assert shown
    for together, width, height in shown:
        assert together == "avoid"
        assert 200 < width < A4_TEXT[0]
        assert height < A4_TEXT[1] / 3
    content = tab.pdf(prefer_css_page_size=True)
    boxes = re.findall(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", content)
    assert {(round(float(w)), round(float(h))) for w, h in boxes} == {(595, 842)}
    pages = re.findall(rb"/Type /Page\b", content)
    lines = tab.evaluate("document.documentElement.scrollHeight") / A4_TEXT[1]
    assert lines <= len(pages) <= 1.5 * lines + 1
    assert len(re.findall(rb"/Subtype /Image\b", content)) >= len(RED_AND_NAVY)
    assert tab.complaints == []
    tab.close()
