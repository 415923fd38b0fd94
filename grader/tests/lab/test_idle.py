"""Workers that nobody uses end, and start again."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

import pytest

from grader.lab import Core, check
from grader.lab.bridge import idle
from grader.lab.cells.judge import JUDGE


class Loop:
    """Stands for a kernel's loop, whose time does not pass by itself."""

    def __init__(self) -> None:
        self.waiting: list[Callable[[], object]] = []

    def call_later(self, seconds: float, act: Callable[[], object]) -> Loop:
        """Note what is to be done."""
        assert seconds == idle.SECONDS
        self.waiting.append(act)
        return self

    def cancel(self) -> None:
        """Take back what was noted last."""
        self.waiting.pop()


@pytest.fixture
def loop(monkeypatch: pytest.MonkeyPatch) -> Loop:
    """Return the loop that cells would run in."""
    made = Loop()
    monkeypatch.setattr(asyncio, "get_running_loop", lambda: made)
    return made


def test_the_worker_of_a_notebook_ends_when_it_is_idle(core: Core, loop: Loop) -> None:
    """Each call counts the time again; what ended starts anew, with the scene that was chosen."""
    core.scene(4)
    core.render()
    before = core.render()
    assert len(loop.waiting) == 1
    loop.waiting.pop()()
    assert core.engine._worker is None
    core.engine._idle._timer = None
    assert (core.render() == before).all()
    assert core.engine._worker is not None


def test_what_check_holds_ends_too(folder: object, loop: Loop) -> None:
    """Its builds are forgotten; the next check opens them again."""
    check("TP1.1")
    loop.waiting.pop()()
    assert JUDGE._libraries is None
    JUDGE._idle._timer = None
    assert check("TP1.1").text.startswith("✓")


def test_without_a_loop_nothing_is_ended(core: Core) -> None:
    """As in a script: there is no moment at which it could be."""
    core.render()
    assert core.engine._idle._timer is None
