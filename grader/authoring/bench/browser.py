"""JupyterLab as `make lab` starts it, on a student's folder, with the machine's Chromium on it.

For the tests and the benchmarks that need a real browser; `NoBrowser` says why there is none.
"""

from __future__ import annotations

import contextlib
import shutil
import socket
import subprocess
import time
import urllib.request
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grader.authoring.workbook.notebooks import NOTEBOOKS, Cell
from grader.course.exercises import CORE, ROOT
from grader.lab import __main__

CHROMIUM = "/usr/bin/chromium"
ARGUMENTS = [
    *("--no-sandbox", "--disable-gpu", "--disable-background-networking"),
    *("--disable-component-update", "--disable-sync", "--no-first-run"),
]
SECONDS = 120  # for anything to happen, on a loaded machine
TRIES, STARTED_SECONDS = 4, 10  # for the first cell to begin
LOST_SECONDS = 30  # without a word from the kernel: what the page has asked has not reached it
CELL = ".jp-Notebook .jp-Cell"
PROMPT = f"{CELL} .jp-InputPrompt"
NOTEBOOK, SOURCE = "notebooks/en/TP2.ipynb", "core_c/raytracer.c"
WIDE = {"width": 1400, "height": 1000}
PICTURE = ".jp-OutputArea-output :is(img, .mrt-drawing)"
DATA = "found.src || found.outerHTML"  # of a picture
# When the server has last heard of its kernels.
HEARD = """async () => {
    const data = JSON.parse(document.getElementById('jupyter-config-data').textContent);
    const kernels = await (await fetch(`${data.baseUrl}api/kernels`)).json();
    return kernels.map((each) => each.last_activity).join();
}"""
LOCAL = ("http://127.0.0.1", "ws://127.0.0.1", "data:", "blob:")


class NoBrowser(Exception):
    """What is missing for a browser to be driven: one line that names the cure."""


class NoJupyter(Exception):
    """JupyterLab did not answer."""


@contextlib.contextmanager
def chromium() -> Iterator[Any]:
    """Start the browser. Raises NoBrowser."""
    if not Path(CHROMIUM).exists():
        raise NoBrowser(f"{CHROMIUM} is missing: apt install chromium")
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        raise NoBrowser("playwright is missing: it comes with `make test`") from None
    with sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield started
        started.close()


@dataclass
class BrowserSession:
    """A page of JupyterLab, the student's folder, and what the browser complained of."""

    page: Any
    folder: Path
    cells: Sequence[Cell]  # of the notebook
    complaints: list[str]

    def run_all(self, seconds: float = SECONDS) -> None:
        """Run every cell, and wait until the last has run again."""
        last = max(n for n, each in enumerate(self.cells) if each.kind == "code")
        self._run(last, self._menu_run_all, seconds)

    def run(self, cell: int) -> None:
        """Run one cell as a person does, and wait until it has run."""
        self._run(cell, lambda: self._press_run(cell))

    def cell(self, start: str) -> int:
        """Return the number of the only cell of code of the notebook that starts so."""
        cells = enumerate(self.cells)
        (found,) = (n for n, each in cells if each.kind == "code" and each.source.startswith(start))
        return found

    def output(self, cell: int) -> Any:
        """Return what a cell shows."""
        return self.page.locator(CELL).nth(cell).locator(".jp-OutputArea")

    def told(self, cell: int, words: str) -> str:
        """Wait until a cell shows these words; return all the text that it shows."""
        area = self.output(cell).filter(has_text=words)
        area.wait_for(state="attached")
        return str(area.inner_text())

    def picture(self, cell: int) -> str:
        """Return the data of the first picture that a cell shows."""
        picture = self.output(cell).locator(PICTURE).first
        picture.wait_for()
        return str(picture.evaluate(f"(found) => {DATA}"))

    def wait_for_another_picture(self, cell: int, old: str) -> None:
        """Wait until a cell shows another picture than that of `old`."""
        found = f"document.querySelectorAll({CELL!r})[cell].querySelector({PICTURE!r})"
        self.page.wait_for_function(
            f"([cell, old]) => {{ const found = {found}; return found && ({DATA}) !== old; }}",
            arg=[cell, old],
        )

    def edit(self, old: str, new: str) -> None:
        """Save another text in the C file, as an editor would."""
        path = self.folder / SOURCE
        text = path.read_text(encoding="utf-8")
        if old not in text:
            raise ValueError(f"{path}: does not hold {old!r}")
        path.write_text(text.replace(old, new, 1), encoding="utf-8")

    def open(self, address: str) -> None:
        """Go to a page of the server; wait until its kernel is there."""
        self.page.goto(address)
        self.page.wait_for_selector(CELL)
        self.page.wait_for_selector(".jp-Notebook-ExecutionIndicator[data-status='idle']")

    def _run(self, cell: int, start: Callable[[], None], seconds: float = SECONDS) -> None:
        """Run cells; once more, on the page opened again, what has never reached the kernel."""
        if not self._has_run(cell, start, seconds):
            self.open(self.page.url)
            assert self._has_run(cell, start, seconds), "the kernel hears nothing"

    def _has_run(self, cell: int, start: Callable[[], None], seconds: float) -> bool:
        """Start cells; wait until that one has run, or its kernel has clearly heard of none."""
        from playwright.sync_api import TimeoutError as Lost

        heard = self.page.evaluate(HEARD)
        before = self.page.locator(CELL).nth(cell).locator(".jp-InputPrompt").inner_text()
        for _ in range(TRIES):
            start()
            # A click on the menu is lost while JupyterLab is still busy with its own start.
            with contextlib.suppress(Lost):
                self._wait_for_prompt(cell, "text !== old", before, STARTED_SECONDS)
                break
        has_run = "text !== old && /[0-9]/.test(text)"
        with contextlib.suppress(Lost):
            self._wait_for_prompt(cell, has_run, before, LOST_SECONDS)
            return True
        if self.page.evaluate(HEARD) == heard:
            return False
        self._wait_for_prompt(cell, has_run, before, seconds)
        return True

    def _menu_run_all(self) -> None:
        self.page.click(f"{PROMPT} >> nth=0")
        self.page.click(".lm-MenuBar-itemLabel:text-is('Run')")
        self.page.click(".lm-Menu-itemLabel:text-is('Run All Cells')")

    def _press_run(self, cell: int) -> None:
        self.page.locator(CELL).nth(cell).locator(".jp-InputPrompt").click()
        self.page.keyboard.press("Control+Enter")

    def _wait_for_prompt(self, cell: int, condition: str, old: str, seconds: float) -> None:
        """Wait until the prompt of a cell (`text`) fulfils a condition."""
        self.page.wait_for_function(
            "([selector, cell, old]) => { const text = document.querySelectorAll(selector)[cell]"
            f".querySelector('.jp-InputPrompt').innerText; return {condition}; }}",
            arg=[CELL, cell, old],
            timeout=seconds * 1000,
        )


def write(project: Path, cells: Sequence[str] | None = None, notebook: str = NOTEBOOK) -> None:
    """Make a student's folder: the reference as the work done, and a notebook of these cells.

    Without cells it is the workbook's own of that name, with its images.
    """
    shutil.copytree(CORE, project / "core_c")
    for path in (ROOT / "reference").glob("*.[ch]"):
        shutil.copyfile(path, project / "core_c" / path.name)
    target = project / notebook
    target.parent.mkdir(parents=True)
    if cells is None:
        shutil.copyfile(ROOT / notebook, target)
        shutil.copytree(NOTEBOOKS / "images", target.parents[1] / "images")
        return
    import nbformat

    made = [nbformat.v4.new_code_cell(each) for each in cells]  # type: ignore[no-untyped-call]
    book = nbformat.v4.new_notebook(cells=made)  # type: ignore[no-untyped-call]
    book.metadata.kernelspec = {"name": "python3", "display_name": "Python 3", "language": "python"}
    nbformat.write(book, target)  # type: ignore[no-untyped-call]


@contextlib.contextmanager
def session(
    project: Path, home: Path, prefix: str = "/", notebook: str = NOTEBOOK
) -> Iterator[BrowserSession]:
    """Start JupyterLab on a notebook, under a prefix of its address, and a browser on it.

    `home` is a folder for Jupyter's own files. Raises NoBrowser, NoJupyter.
    """
    import nbformat

    # JupyterLab writes the file again meanwhile, not in one go.
    book = nbformat.read(project / notebook, as_version=4)  # type: ignore[no-untyped-call]
    cells = [Cell(each.cell_type, each.source) for each in book.cells]
    with chromium() as browser, _server(project, home, prefix, notebook) as address:
        page = browser.new_page(viewport=WIDE)
        page.set_default_timeout(SECONDS * 1000)
        made = BrowserSession(page, project, cells, _listen(page))
        made.open(address)
        yield made


@contextlib.contextmanager
def _server(project: Path, home: Path, prefix: str, notebook: str) -> Iterator[str]:
    """Start JupyterLab; yield the address of its workspace."""
    workspace = __main__.write_workspace(home, notebook, SOURCE)
    __main__.write_settings(home)
    port = _free_port()
    command = [*__main__.command(project, workspace, True), f"--ServerApp.port={port}"]
    command += ["--IdentityProvider.token=lab", f"--ServerApp.base_url={prefix}"]
    variables = {**__main__.environment(home), "BUILD": str(home / "build")}
    variables.pop("MRT_CORE", None)
    address = f"http://127.0.0.1:{port}{prefix}"
    with (home / "log").open("w") as log:
        server = subprocess.Popen(command, env=variables, cwd=project, stdout=log, stderr=log)
        try:
            _wait_for(f"{address}api?token=lab", server)
            yield f"{address}lab/workspaces/{workspace}?token=lab"
        finally:
            server.terminate()
            server.wait(SECONDS)


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
    raise NoJupyter(f"JupyterLab does not answer (exit code {server.poll()})")


def _listen(page: Any) -> list[str]:
    """Note errors of the console, and requests that leave this machine."""
    complaints: list[str] = []

    def outside(request: Any) -> None:
        if not request.url.startswith(LOCAL):
            complaints.append(f"request to {request.url}")

    page.on("console", lambda said: complaints.append(said.text) if said.type == "error" else None)
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("request", outside)
    return complaints
