"""A lab session in JupyterLab itself: notebook and C file side by side, in a real browser."""

from __future__ import annotations

import contextlib
import os
import shutil
import socket
import subprocess
import time
import urllib.request
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import nbformat
import pytest

from grader.lab import __main__ as lab
from grader.manifest import CORE, ROOT

CHROMIUM = "/usr/bin/chromium"
FLAGS = (
    *("--no-sandbox", "--disable-gpu", "--disable-background-networking"),
    *("--disable-component-update", "--disable-sync", "--no-first-run"),
)
SECONDS = 120  # for anything to happen, on a loaded machine
TRIES, STARTED_SECONDS = 4, 10  # for the first cell to begin
PROMPT = ".jp-Notebook .jp-Cell .jp-InputPrompt"
NOTEBOOK, SOURCE = "notebooks/en/TP2.ipynb", "core_c/raytracer.c"
CELLS = (
    "from grader.lab import Core, check, predict, slider\n\ncore = Core()\ncore.size = (160, 90)",
    "slider(lambda k: core.render(scene=k), k=[0, 4])",
    'predict("tp2.side", "AB")',
    "core.render(scene=0)",
    'check("TP1.1")',
)
SLIDER, PICTURE, LAST = 1, 3, 4
DOT = "float n_l = vector_dot(n, l);"


@dataclass
class Session:
    """A page of JupyterLab, the student's folder, and what the browser complained of."""

    page: Any
    folder: Path
    complaints: list[str]

    def run_all(self) -> None:
        """Run every cell, and wait until the last has run again."""
        lost = pytest.importorskip("playwright.sync_api").TimeoutError
        before = self.page.locator(PROMPT).last.inner_text()
        for _ in range(TRIES):
            self.page.click(f"{PROMPT} >> nth=0")
            self.page.click(".lm-MenuBar-itemLabel:text-is('Run')")
            self.page.click(".lm-Menu-itemLabel:text-is('Run All Cells')")
            # A click on the menu is lost while JupyterLab is still busy with its own start.
            with contextlib.suppress(lost):
                self._wait_for_last("text !== old", before, STARTED_SECONDS)
                break
        self._wait_for_last("text !== old && /[0-9]/.test(text)", before, SECONDS)

    def _wait_for_last(self, condition: str, old: str, seconds: float) -> None:
        """Wait until the prompt of the last cell (`text`) fulfils a condition."""
        self.page.wait_for_function(
            f"(old) => {{ const prompts = document.querySelectorAll('{PROMPT}');"
            f"const text = prompts[prompts.length - 1].innerText; return {condition}; }}",
            arg=old,
            timeout=seconds * 1000,
        )

    def output(self, cell: int) -> Any:
        """Return what a cell shows."""
        return self.page.locator(".jp-Notebook .jp-Cell").nth(cell).locator(".jp-OutputArea")

    def picture(self, cell: int) -> str:
        """Return the data of the picture that a cell shows."""
        image = self.output(cell).locator("img").first
        image.wait_for()
        return str(image.get_attribute("src"))

    def edit(self, old: str, new: str) -> None:
        """Save another text in the C file, as an editor would."""
        path = self.folder / SOURCE
        text = path.read_text(encoding="utf-8")
        assert old in text
        path.write_text(text.replace(old, new, 1), encoding="utf-8")


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a student's folder, the reference as the work done, with a short notebook."""
    place = tmp_path_factory.mktemp("projet")
    shutil.copytree(CORE, place / "core_c")
    for path in (ROOT / "reference").glob("*.[ch]"):
        shutil.copyfile(path, place / "core_c" / path.name)
    cells = [nbformat.v4.new_code_cell(each) for each in CELLS]  # type: ignore[no-untyped-call]
    book = nbformat.v4.new_notebook(cells=cells)  # type: ignore[no-untyped-call]
    book.metadata.kernelspec = {"name": "python3", "display_name": "Python 3", "language": "python"}
    (place / NOTEBOOK).parent.mkdir(parents=True)
    nbformat.write(book, place / NOTEBOOK)  # type: ignore[no-untyped-call]
    return place


@pytest.fixture(scope="module")
def session(project: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Session]:
    """Start JupyterLab as `make lab` does, and a browser on it."""
    playwright = pytest.importorskip("playwright.sync_api")
    if not Path(CHROMIUM).exists():
        reason = f"{CHROMIUM} is missing: apt install chromium"
        pytest.fail(reason) if os.environ.get("MRT_CI") == "1" else pytest.skip(reason)
    home = tmp_path_factory.mktemp("jupyter")
    workspace = lab.write_workspace(home, NOTEBOOK, SOURCE)
    lab.write_settings(home)
    port = _free_port()
    command = [*lab.command(project, workspace, True), f"--ServerApp.port={port}"]
    command.append("--IdentityProvider.token=lab")
    variables = {**lab.environment(home), "BUILD": str(home / "build")}
    variables.pop("MRT_CORE", None)
    log = (home / "log").open("w")
    server = subprocess.Popen(command, env=variables, cwd=project, stdout=log, stderr=log)
    try:
        _wait_for(f"http://127.0.0.1:{port}/api?token=lab", server)
        with playwright.sync_playwright() as tools:
            browser = tools.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
            page = browser.new_page(viewport={"width": 1400, "height": 1000})
            page.set_default_timeout(SECONDS * 1000)
            made = Session(page, project, _listen(page))
            page.goto(f"http://127.0.0.1:{port}/lab/workspaces/{workspace}?token=lab")
            page.wait_for_selector(".jp-Notebook .jp-Cell")
            page.wait_for_selector(".jp-Notebook-ExecutionIndicator[data-status='idle']")
            yield made
            browser.close()
    finally:
        server.terminate()
        server.wait(SECONDS)
        log.close()


def _free_port() -> int:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


def _wait_for(url: str, server: subprocess.Popen[bytes]) -> None:
    deadline = time.monotonic() + SECONDS
    while time.monotonic() < deadline and server.poll() is None:
        try:
            with urllib.request.urlopen(url, timeout=5):
                return
        except OSError:
            time.sleep(0.2)
    pytest.fail(f"JupyterLab does not answer (exit code {server.poll()})")


def _listen(page: Any) -> list[str]:
    """Note errors of the console, and requests that leave this machine."""
    complaints: list[str] = []

    def outside(request: Any) -> None:
        if not request.url.startswith(("http://127.0.0.1", "ws://127.0.0.1", "data:", "blob:")):
            complaints.append(f"request to {request.url}")

    page.on("console", lambda said: complaints.append(said.text) if said.type == "error" else None)
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("request", outside)
    return complaints


def _screenshot(session: Session, name: str) -> None:
    """Keep what the page looks like, where MRT_SCREENSHOTS names a folder."""
    folder = os.environ.get("MRT_SCREENSHOTS")
    if folder:
        session.page.screenshot(path=f"{folder}/lab-{name}.png")


def test_a_lab_session(session: Session) -> None:
    """Side by side; run all; a slider; a broken file; mended; a crash; and nothing complains."""
    page = session.page
    assert page.locator(".jp-FileEditor").is_visible()
    session.run_all()
    before = session.picture(PICTURE)
    assert "right, 2 / 2" in session.output(LAST).inner_text()
    _screenshot(session, "run")

    slow = session.picture(SLIDER)
    handle = session.output(SLIDER).locator(".noUi-handle")
    handle.focus()
    page.keyboard.press("ArrowRight")
    page.wait_for_function(
        "([cell, old]) => { const image = document.querySelectorAll('.jp-Notebook .jp-Cell')[cell]"
        ".querySelector('.jp-OutputArea img'); return image && image.src !== old; }",
        arg=[SLIDER, slow],
    )
    _screenshot(session, "slider")

    session.output(2).locator("button:text-is('B')").click()

    session.edit(DOT, DOT.replace(";", ""))
    session.run_all()
    told = session.output(PICTURE).inner_text()
    assert "error: expected" in told
    assert "^" in told
    assert "Traceback" not in page.inner_text(".jp-Notebook")
    _screenshot(session, "broken")
    session.output(PICTURE).locator("a").first.click()
    page.wait_for_function(
        "() => [...document.querySelectorAll('.jp-FileEditor .cm-line')]"
        ".some((line) => line.innerText.includes('float n_l'))"
    )
    _screenshot(session, "link")

    session.edit(DOT.replace(";", ""), DOT)
    session.run_all()
    assert session.picture(PICTURE) == before

    session.edit(DOT, f"{DOT} volatile int *p = 0; *p = 1;")
    session.run_all()
    assert "in shade (raytracer.c:" in session.output(PICTURE).inner_text()
    assert "right, 2 / 2" in session.output(LAST).inner_text()  # the cells behind it have run
    _screenshot(session, "crash")
    kept = session.output(2).locator("button.mod-active").inner_text()
    assert kept.strip() == "B"
    assert session.complaints == []
