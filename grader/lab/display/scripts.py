"""The scripts of widgets: each is one module for the browser, with what they share before it."""

from __future__ import annotations

from pathlib import Path

_SHARED = Path(__file__).with_name("dom.js")


def script(path: Path) -> str:
    """Return a widget's script as the browser takes it."""
    return _SHARED.read_text(encoding="utf-8") + path.read_text(encoding="utf-8")
