"""What a submission may take in all: counted by kind, its clock slowed by the machine's load."""

from __future__ import annotations

import math
import os

import pytest

from grader.sandbox import budget
from grader.sandbox.budget import ASLEEP, CPU, SECONDS, WALL, Budget


class Machine:
    """A clock and a load to be set."""

    def __init__(self) -> None:
        self.now, self.busy = 100.0, 1.0

    def budget(self) -> Budget:
        """Return a budget that begins now."""
        return Budget(clock=lambda: self.now, load=lambda: self.busy)


def test_each_kind_is_spent_for_itself() -> None:
    """Nothing is spent at first; the kind that is used up is named, and nothing is left of it."""
    own = Machine().budget()
    assert (own.spent, own.left(CPU), own.left(ASLEEP)) == ("", SECONDS[CPU], SECONDS[ASLEEP])
    own.spend(cpu=SECONDS[CPU] - 1, asleep=1)
    assert (own.spent, own.left(CPU), own.left(ASLEEP)) == ("", 1, SECONDS[ASLEEP] - 1)
    own.spend(cpu=2)
    assert (own.spent, own.left(CPU)) == (CPU, 0)


def test_the_clock_is_slowed_by_the_load() -> None:
    """With ten processes for each processor, ten minutes count as one; then one as one."""
    machine = Machine()
    own = machine.budget()
    machine.busy, machine.now = 10.0, machine.now + 600
    assert own.left() == 10 * (SECONDS[WALL] - 60)
    machine.busy, machine.now = 1.0, machine.now + 59
    assert (own.left(), own.spent) == (SECONDS[WALL] - 119, "")
    machine.now += 2
    assert (own.left(), own.spent) == (0, WALL)


def test_who_loops_again_and_again_has_less_time() -> None:
    """After a few calls that do not end; in a person's own session never."""
    own, endless = Machine().budget(), Budget.endless()
    for _ in range(budget.LOOPS):
        assert own.share == 1
        own.spend(loops=1)
        endless.spend(loops=1)
    assert (own.share, endless.share) == (budget.SHARE, 1)


def test_a_person_s_own_session_is_not_bounded() -> None:
    """A notebook stays open for hours."""
    own = Budget.endless()
    own.spend(cpu=1e9, asleep=1e9)
    assert (own.spent, own.left()) == ("", math.inf)


def test_the_load_is_measured_for_each_processor(monkeypatch: pytest.MonkeyPatch) -> None:
    """One at least; where the system does not tell, one."""
    monkeypatch.setattr(os, "cpu_count", lambda: 4)
    for told, expected in ((0.1, 1.0), (8.0, 2.0), (4e3, budget.MOST_LOAD)):
        monkeypatch.setattr(os, "getloadavg", lambda told=told: (told, 0.0, 0.0))
        assert budget.load() == expected

    def untold() -> None:
        raise OSError

    monkeypatch.setattr(os, "getloadavg", untold)
    assert budget.load() == 1.0
