"""The machine's Chromium, for the tests that open pages."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from grader.authoring.bench import browser

SETTLED = 500  # milliseconds, for what was scrolled to be drawn


@contextmanager
def wanted() -> Iterator[None]:
    """Skip the test where the browser is missing; with MRT_CI=1 it fails instead."""
    try:
        yield
    except browser.NoBrowser as error:
        pytest.fail(str(error)) if os.environ.get("MRT_CI") == "1" else pytest.skip(str(error))


@contextmanager
def chromium() -> Iterator[Any]:
    """Start the browser; where it is missing the test is skipped, and fails with MRT_CI=1."""
    with wanted(), browser.chromium() as started:
        yield started


def screenshot(page: Any, name: str) -> None:
    """Keep what a page looks like, where MRT_SCREENSHOTS names a folder."""
    folder = os.environ.get("MRT_SCREENSHOTS")
    if folder:
        page.wait_for_timeout(SETTLED)
        page.screenshot(path=f"{folder}/{name}.png")
