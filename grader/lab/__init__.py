"""What the notebooks are written with: see `Core`, and each function's own help.

    from grader.lab import Core, check, compare, figure, help_card, inspect, new_figure, predict
    from grader.lab import predicted, progress, show, slider, source

    core = Core()                        # the C functions: core.fill_red(img), core.render(scene=0)
    show(core.figure("figure_4"))        # a picture on axes
    compare(core.figure("figure_4"), "figure_4")
    check("TP2.4")                       # what the grader says
    inspect(0, (150, 70))                # why a pixel is its colour

Each returns what the cell shows when it is the cell's last expression. What goes wrong in the C
code ends the cell with a card, not the notebook.
"""

from __future__ import annotations

from grader.lab import stopped
from grader.lab.checks import check
from grader.lab.comparing import compare
from grader.lab.core import Core
from grader.lab.inspector import inspect
from grader.lab.picture import Picture, figure, new_figure, show
from grader.lab.predictions import predict, predicted
from grader.lab.sliders import slider
from grader.lab.sources import source
from grader.lab.standing import help_card, progress
from grader.lab.stopped import Stopped

__all__ = [
    "Core",
    "Picture",
    "Stopped",
    "check",
    "compare",
    "figure",
    "help_card",
    "inspect",
    "new_figure",
    "predict",
    "predicted",
    "progress",
    "show",
    "slider",
    "source",
]

stopped.install()
