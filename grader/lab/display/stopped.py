"""What ends a cell early, told in a card instead of a traceback; the notebook goes on."""

from __future__ import annotations

import sys
from types import TracebackType
from typing import Any

from grader.lab.display.card import Shown


class Printed(Shown):
    """What C code has printed; a cell shows it as plain text."""


class Stopped(Exception):
    """The student's code could not be built, or did not come back; `shown` says it.

    The cell ends there. In a notebook the cells after it run all the same, but for those that were
    waiting when the stop button was pressed (`by_hand`).
    """

    def __init__(self, shown: Shown, by_hand: bool = False) -> None:
        super().__init__(shown.text)
        self.shown, self.by_hand = shown, by_hand


def install() -> bool:
    """In a notebook, show a Stopped as its card, and go on with the next cell; say if it is one."""
    shell = _shell()
    if shell is None:
        return False

    def handle(
        shell: Any,
        kind: type[BaseException],
        error: BaseException,
        trace: TracebackType | None,
        tb_offset: int | None = None,
    ) -> None:
        if isinstance(error, Stopped):
            display(error.shown)

    def settle(result: Any) -> None:
        # A cell in error would have JupyterLab drop the cells that wait behind it.
        error = result.error_in_exec
        if isinstance(error, Stopped) and not error.by_hand:
            result.error_in_exec = None

    shell.set_custom_exc((Stopped,), handle)
    shell.events.register("post_run_cell", settle)
    return True


def display(shown: Shown) -> None:
    """Show something at once, in the cell that runs; on a terminal, its text."""
    if _shell() is None or isinstance(shown, Printed):
        sys.stdout.write(f"{shown.text}\n")
        return
    from IPython.display import display as show

    show(shown)  # type: ignore[no-untyped-call]


def _shell() -> Any:
    """Return IPython's shell; None outside of it."""
    if "IPython" not in sys.modules:
        return None
    from IPython.core.getipython import get_ipython

    return get_ipython()  # type: ignore[no-untyped-call]
