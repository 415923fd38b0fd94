"""The pixel inspector in JupyterLab, behind a JupyterHub-like prefix, in a real browser."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import nbformat
import pytest

from grader.lab import __main__ as lab
from grader.manifest import CORE, ROOT
from grader.tests.browser import test_lab as tools

NOTEBOOK, SOURCE = "notebooks/en/TP2.ipynb", "core_c/raytracer.c"
PREFIX = "/user/someone/"  # as JupyterHub gives each person
CELL = "from grader.lab import inspect\n\ninspect(0, (160, 60))"
WIDE, PHONE, ZOOMED = (1400, 1000), (420, 800), (700, 500)  # the last: 200 % of the first
DOT = "float n_l = vector_dot(n, l);"


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tools.Session]:
    """Start JupyterLab behind the prefix, on a notebook of one cell, and a browser on it."""
    playwright = pytest.importorskip("playwright.sync_api")
    if not Path(tools.CHROMIUM).exists():
        reason = f"{tools.CHROMIUM} is missing: apt install chromium"
        pytest.fail(reason) if os.environ.get("MRT_CI") == "1" else pytest.skip(reason)
    project, home = tmp_path_factory.mktemp("projet"), tmp_path_factory.mktemp("jupyter")
    _write(project)
    workspace = lab.write_workspace(home, NOTEBOOK, SOURCE)
    lab.write_settings(home)
    port = tools._free_port()
    command = [*lab.command(project, workspace, True), f"--ServerApp.port={port}"]
    command += ["--IdentityProvider.token=lab", f"--ServerApp.base_url={PREFIX}"]
    variables = {**lab.environment(home), "BUILD": str(home / "build")}
    variables.pop("MRT_CORE", None)
    log = (home / "log").open("w")
    server = subprocess.Popen(command, env=variables, cwd=project, stdout=log, stderr=log)
    address = f"http://127.0.0.1:{port}{PREFIX}"
    try:
        tools._wait_for(f"{address}api?token=lab", server)
        with playwright.sync_playwright() as started:
            browser = started.chromium.launch(
                executable_path=tools.CHROMIUM, args=list(tools.FLAGS)
            )
            page = browser.new_page(viewport=_size(WIDE))
            page.set_default_timeout(tools.SECONDS * 1000)
            made = tools.Session(page, project, tools._listen(page))
            page.goto(f"{address}lab/workspaces/{workspace}?token=lab")
            page.wait_for_selector(".jp-Notebook .jp-Cell")
            page.wait_for_selector(".jp-Notebook-ExecutionIndicator[data-status='idle']")
            yield made
            browser.close()
    finally:
        server.terminate()
        server.wait(tools.SECONDS)
        log.close()


def _write(project: Path) -> None:
    """Make a student's folder: the reference as the work done, and the notebook."""
    shutil.copytree(CORE, project / "core_c")
    for path in (ROOT / "reference").glob("*.[ch]"):
        shutil.copyfile(path, project / "core_c" / path.name)
    book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(CELL)])  # type: ignore[no-untyped-call]
    book.metadata.kernelspec = {"name": "python3", "display_name": "Python 3", "language": "python"}
    (project / NOTEBOOK).parent.mkdir(parents=True)
    nbformat.write(book, project / NOTEBOOK)  # type: ignore[no-untyped-call]


def _size(pair: tuple[int, int]) -> dict[str, int]:
    return {"width": pair[0], "height": pair[1]}


def _wait_pixel(page: Any, i: int, j: int) -> None:
    """Wait until the table is that of a pixel."""
    page.wait_for_selector(f".mrt-told[data-pixel='{i},{j}']")


def _drawn(page: Any) -> str:
    """Return what the view in space shows, as data."""
    return str(page.evaluate("() => document.querySelector('.mrt-space').toDataURL()"))


def _screenshot(page: Any, name: str) -> None:
    folder = os.environ.get("MRT_SCREENSHOTS")
    if folder:
        page.screenshot(path=f"{folder}/inspector-{name}.png")


def test_the_inspector_at_work(session: tools.Session) -> None:
    """Click, keys, zoom, orbit, linked rows; a crash and its mending; small windows; no error."""
    page = session.page
    session.run_all()
    _wait_pixel(page, 160, 60)
    _screenshot(page, "open")

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
    _screenshot(page, "lit")

    _break_and_mend(session)
    for size, name in ((PHONE, "phone"), (ZOOMED, "zoomed")):
        page.set_viewport_size(_size(size))
        page.wait_for_timeout(500)
        wide = "(each) => each.scrollWidth <= each.clientWidth + 1"
        assert page.locator(".mrt-inspector").evaluate(wide)
        page.locator(".mrt-inspector").scroll_into_view_if_needed()
        _screenshot(page, name)
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


def _break_and_mend(session: tools.Session) -> None:
    """Make it crash: the widget tells the line; after mending, the next pixel works."""
    page = session.page
    session.edit(DOT, f"{DOT} volatile int *p = 0; *p = 1;")
    page.locator(".mrt-picture").focus()
    page.keyboard.press("ArrowLeft")
    _wait_pixel(page, 90, 60)
    told = page.locator(".mrt-told").inner_text()
    assert "your code stops on the way" in told
    assert "in shade (raytracer.c:" in told
    _screenshot(page, "crash")
    session.edit(f"{DOT} volatile int *p = 0; *p = 1;", DOT)
    page.keyboard.press("ArrowLeft")
    _wait_pixel(page, 89, 60)
    assert "Each value of this pixel" in page.locator(".mrt-told").inner_text()
