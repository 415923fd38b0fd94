"""The machine's Chromium, for the tests that open pages."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

CHROMIUM = "/usr/bin/chromium"
ARGUMENTS = [
    *("--no-sandbox", "--disable-gpu", "--disable-background-networking"),
    *("--disable-component-update", "--disable-sync", "--no-first-run"),
]


@contextmanager
def chromium() -> Iterator[Any]:
    """Start the browser; where it is missing the test is skipped, and fails with MRT_CI=1."""
    if not Path(CHROMIUM).exists():
        reason = f"{CHROMIUM} is missing: apt install chromium"
        pytest.fail(reason) if os.environ.get("MRT_CI") == "1" else pytest.skip(reason)
    playwright = pytest.importorskip("playwright.sync_api")
    with playwright.sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield started
        started.close()


def screenshot(page: Any, name: str) -> None:
    """Keep what a page looks like, where MRT_SCREENSHOTS names a folder."""
    folder = os.environ.get("MRT_SCREENSHOTS")
    if folder:
        page.screenshot(path=f"{folder}/{name}.png")
