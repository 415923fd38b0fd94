"""How many programs may run side by side."""

from __future__ import annotations

import os

import pytest

from grader.sandbox import cores


def test_those_are_counted_that_this_process_may_use(monkeypatch: pytest.MonkeyPatch) -> None:
    """`taskset` leaves it fewer; where the system does not tell, all count, and one at least."""
    monkeypatch.setattr(os, "sched_getaffinity", lambda pid: {3}, raising=False)
    assert cores.usable() == 1
    monkeypatch.delattr(os, "sched_getaffinity")
    for told, expected in ((6, 6), (None, 1)):
        monkeypatch.setattr(os, "cpu_count", lambda told=told: told)
        assert cores.usable() == expected
