"""Sentences at a terminal's width."""

from __future__ import annotations

import fcntl
import io
import pty
import struct
import termios

import pytest

from grader.setup.folding import folded, put, width
from grader.tests.support.terminals import read_all

LONG = "Après intersect_plane(r, it, obj), r->tmax vaut 3 : voyez make grade K=TP2.3 HINT=2 !"


@pytest.mark.parametrize("columns", range(30, 90))
def test_no_line_is_wider_and_nothing_is_torn(columns: int) -> None:
    """Names of C, commands with their settings, and French punctuation with its word stay whole."""
    lines = folded(LONG, columns)
    assert max(map(len, lines)) <= columns
    assert " ".join(line.strip() for line in lines) == LONG
    for whole in ("r->tmax", "3 :", "make grade K=TP2.3 HINT=2 !"):
        assert sum(whole in line for line in lines) == 1


def test_a_list_goes_on_under_its_beginning() -> None:
    """A table's rows and the compiler's lines are left as they are; so is everything in a file."""
    names = "  TP2  " + ", ".join(f"function_{k}" for k in range(9))
    assert all(line.startswith("  ") for line in folded(names, 40))
    for line in ("   12 | " + "x" * 90, "     a table " * 9):
        assert folded(line, 40) == [line]
    assert folded(LONG, 0) == [LONG]


def test_only_a_terminal_folds() -> None:
    """Each line of a text by itself."""
    out = io.StringIO()
    put(f"{LONG}\nfin", out)
    assert out.getvalue() == f"{LONG}\nfin\n"
    assert width(out) == 0
    reading, writing = pty.openpty()
    with open(writing, "w", encoding="utf-8") as terminal:
        fcntl.ioctl(writing, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 40, 0, 0))
        put(f"{LONG}\nfin", terminal)
    assert read_all(reading).decode().splitlines() == [*folded(LONG, 40), "fin"]
