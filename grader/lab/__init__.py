"""What the notebooks are written with: see `Core`, and each function's own help.

    from grader.lab import Core, check, compare, figure, help_card, inspect, live, new_figure
    from grader.lab import predict, predicted, progress, show, slider, source

    core = Core()                        # the C functions: core.fill_red(img), core.render(scene=0)
    show(core.figure("figure_4"))        # a picture on axes
    compare(core.figure("figure_4"), "figure_4")
    check("TP2.4")                       # what the grader says
    inspect(0, (150, 70))                # why a pixel is its colour
    live(0)                              # a picture that follows the files

Each returns what the cell shows when it is the cell's last expression. What goes wrong in the C
code ends the cell with a card, not the notebook.
"""

from __future__ import annotations

import importlib
from types import ModuleType

from grader.lab.bridge.core import Core
from grader.lab.cells.check import check
from grader.lab.cells.compare import compare
from grader.lab.cells.predict import predict, predicted
from grader.lab.cells.progress import help_card, progress
from grader.lab.cells.slider import slider
from grader.lab.cells.source import source
from grader.lab.display import stopped
from grader.lab.display.picture import Picture, figure, new_figure, show
from grader.lab.display.stopped import Stopped
from grader.lab.inspector import inspect
from grader.lab.live import live
from grader.sandbox import scratch

__all__ = [
    "Core",
    "Picture",
    "Stopped",
    "check",
    "compare",
    "figure",
    "help_card",
    "inspect",
    "live",
    "new_figure",
    "predict",
    "predicted",
    "progress",
    "show",
    "slider",
    "source",
]

_DRAWINGS = ("tp1", "tp2", "tp3", "tp4", "tp4_octree", "tp5", "tp5_samples", "vectors")

if stopped.install():
    scratch.use()  # what a kernel that is killed leaves there, the next one removes


def __getattr__(name: str) -> ModuleType:
    """Return the drawings of a notebook, which are loaded by the notebook that asks for them."""
    if name in _DRAWINGS:
        return importlib.import_module(f"grader.lab.drawings.{name}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
