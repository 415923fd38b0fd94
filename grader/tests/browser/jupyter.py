"""JupyterLab as `make lab` starts it, on a student's folder, with a browser on it."""

from __future__ import annotations

import contextlib
import shutil
import socket
import subprocess
import time
import urllib.request
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import nbformat
import pytest

from grader.lab import __main__ as lab
from grader.manifest import CORE, ROOT
from grader.tests.browser.chromium import chromium

SECONDS = 120  # for anything to happen, on a loaded machine
TRIES, STARTED_SECONDS = 4, 10  # for the first cell to begin
PROMPT = ".jp-Notebook .jp-Cell .jp-InputPrompt"
NOTEBOOK, SOURCE = "notebooks/en/TP2.ipynb", "core_c/raytracer.c"
DOT = "float n_l = vector_dot(n, l);"  # a line of the C file
WIDE = {"width": 1400, "height": 1000}


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


def write(project: Path, cells: Sequence[str]) -> None:
    """Make a student's folder: the reference as the work done, and a notebook of these cells."""
    shutil.copytree(CORE, project / "core_c")
    for path in (ROOT / "reference").glob("*.[ch]"):
        shutil.copyfile(path, project / "core_c" / path.name)
    made = [nbformat.v4.new_code_cell(each) for each in cells]  # type: ignore[no-untyped-call]
    book = nbformat.v4.new_notebook(cells=made)  # type: ignore[no-untyped-call]
    book.metadata.kernelspec = {"name": "python3", "display_name": "Python 3", "language": "python"}
    (project / NOTEBOOK).parent.mkdir(parents=True)
    nbformat.write(book, project / NOTEBOOK)  # type: ignore[no-untyped-call]


@contextlib.contextmanager
def session(project: Path, home: Path, prefix: str = "/") -> Iterator[Session]:
    """Start JupyterLab under a prefix of its address, and a browser on it.

    `home` is a folder for Jupyter's own files.
    """
    with chromium() as browser, _server(project, home, prefix) as address:
        page = browser.new_page(viewport=WIDE)
        page.set_default_timeout(SECONDS * 1000)
        made = Session(page, project, _listen(page))
        page.goto(address)
        page.wait_for_selector(".jp-Notebook .jp-Cell")
        page.wait_for_selector(".jp-Notebook-ExecutionIndicator[data-status='idle']")
        yield made


@contextlib.contextmanager
def _server(project: Path, home: Path, prefix: str) -> Iterator[str]:
    """Start JupyterLab; yield the address of its workspace."""
    workspace = lab.write_workspace(home, NOTEBOOK, SOURCE)
    lab.write_settings(home)
    port = _free_port()
    command = [*lab.command(project, workspace, True), f"--ServerApp.port={port}"]
    command += ["--IdentityProvider.token=lab", f"--ServerApp.base_url={prefix}"]
    variables = {**lab.environment(home), "BUILD": str(home / "build")}
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
