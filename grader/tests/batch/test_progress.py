"""What the terminal shows while a class is graded."""

from __future__ import annotations

import io

from rich.console import Console

from grader.batch.progress import Meter
from grader.course.texts import Texts


def shown(terminal: bool) -> str:
    """Return what three submissions show, the second of which failed."""
    out = io.StringIO()
    console = Console(file=out, force_terminal=terminal, width=100)
    with Meter(Texts("en"), 3, console) as meter:
        for failed in (False, True, False):
            meter.step(failed)
    return out.getvalue()


def test_plain_lines_when_piped() -> None:
    """The last one at least, with count and failures; no control character."""
    (line,) = shown(terminal=False).splitlines()
    assert line.startswith("3/3 ")
    assert line.endswith("0:00 left, failures: 1")
    assert line.isprintable()


def test_a_line_that_moves_on_a_terminal() -> None:
    """The same numbers, in place, and nothing left behind."""
    text = shown(terminal=True)
    assert "3/3" in text
    assert "failures: 1" in text
    assert text.endswith("\x1b[2K")
