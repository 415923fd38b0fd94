"""What sliders and buttons lack in JupyterLab: a name for a handle, an edge, a finger's size."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

from grader.lab.display.scripts import script

SCRIPT = Path(__file__).with_name("controls.js")
STYLE = """
.jupyter-widgets .noUi-handle { border-color: #808080 !important; }
@media (pointer: coarse) {
  .jupyter-widgets .noUi-handle::after { content: ""; position: absolute; inset: -14px; }
  .jupyter-widgets .widget-toggle-button { min-width: 44px; height: 44px; }
}
"""


@cache
def _kind() -> Any:
    import anywidget

    class Controls(anywidget.AnyWidget):
        _esm = script(SCRIPT)
        _css = STYLE

    return Controls


def beside(*controls: Any) -> Any:
    """Return controls one below the other, with what they lack where anywidget is installed."""
    import ipywidgets  # type: ignore[import-untyped]

    try:
        more = [_kind()()]
    except ImportError:
        more = []
    return ipywidgets.VBox([*controls, *more])
