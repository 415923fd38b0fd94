"""Waiting for an answer: what computes, what queues for a processor, and what sleeps on purpose."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from grader.authoring.specimens.student import STUDENT_MAIN, main_c
from grader.execution.patience import Patience, Seconds
from grader.execution.records import Cause, Limits
from grader.execution.session import Library, open_core
from grader.execution.session_socket import Died, SessionSocket
from grader.sandbox import budget
from grader.sandbox.budget import ASLEEP, Budget
from grader.tests.support.judging import judge

Write = Callable[..., Path]
NAP = "extern int usleep(unsigned); usleep({}); img[0].x = 1;"
WALL_SECONDS = 2.0


class Clock:
    """Time, and what the kernel tells of the process, to be set."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now, self.seconds = 50.0, Seconds(1, 1)
        monkeypatch.setattr("grader.execution.patience.time.monotonic", lambda: self.now)
        monkeypatch.setattr(Seconds, "of", lambda pid: self.seconds)

    def pass_by(self, wall: float, running: float = 0, queueing: float = 0) -> None:
        """Let time go by, with what the process has had of it; else it sleeps."""
        before = self.seconds
        asleep = wall > running + queueing
        self.now += wall
        self.seconds = Seconds(before.running + running, before.queueing + queueing, asleep)


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    """Return a clock to be set."""
    return Clock(monkeypatch)


def test_who_queues_is_waited_for(clock: Clock) -> None:
    """A process that is never given a processor is not late, however long it takes."""
    waiting = Patience(1, WALL_SECONDS, Budget(load=lambda: 10.0))
    for _ in range(100):
        clock.pass_by(1, running=0.01, queueing=0.99)
        assert waiting.lost() is None
    clock.pass_by(WALL_SECONDS, running=WALL_SECONDS)
    assert waiting.lost() == (Cause.TIMEOUT, "", 0.0)


def test_who_sleeps_is_told_so(clock: Clock) -> None:
    """Neither computing nor queueing: the code waits, and its seconds are counted."""
    own = Budget()
    waiting = Patience(1, WALL_SECONDS, own)
    clock.pass_by(1)
    assert waiting.lost() is None
    clock.pass_by(1.5)
    assert waiting.lost() == (Cause.WAITING, "", 2)
    assert own.left(ASLEEP) == budget.SECONDS[ASLEEP] - 2.5


def test_short_naps_add_up(clock: Clock) -> None:
    """Below every limit of one call: what a submission sleeps in all is bounded."""
    own = Budget()
    for _ in range(6):
        waiting = Patience(1, WALL_SECONDS, own)
        clock.pass_by(1.8)
        lost = waiting.lost()
    assert lost == (Cause.SPENT, ASLEEP, budget.SECONDS[ASLEEP])


def test_where_the_system_tells_nothing_time_is_all_there_is(clock: Clock) -> None:
    """As on macOS: the wall clock, and no word on what the code did."""
    clock.seconds = Seconds(known=False)
    waiting = Patience(1, WALL_SECONDS, Budget())
    clock.now += 1
    assert waiting.lost() is None
    clock.now += 1.1
    assert waiting.lost() == (Cause.TIMEOUT, "", 0.0)


@pytest.fixture
def sleeper(submission: Write, cache: Path) -> Iterator[Library]:
    """Return a submission whose fill_red sleeps for a while."""
    folder = submission(fill_red=NAP.format(60_000_000))
    with open_core(folder, 96, 64, cache=cache) as library:
        yield library


def test_a_real_sleep_is_seen(sleeper: Library) -> None:
    """The kernel's figures are read, and the place is told."""
    limits = Limits(cpu=0.1)
    with pytest.raises(Died) as caught, sleeper.session(limits) as session:
        session.call("fill_red", sleeper.zeros("vec3", 96 * 64))
    death = caught.value.death
    assert (death.cause, death.function) == (Cause.WAITING, "fill_red")
    assert death.seconds >= limits.wall / 2


@pytest.fixture
def sessions(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return the libraries whose sessions are opened, as they are."""
    found: list[str] = []
    begin = SessionSocket.begin

    def noting(self: SessionSocket) -> None:
        found.append(self._library)
        begin(self)

    monkeypatch.setattr(SessionSocket, "begin", noting)
    return found


def test_a_submission_that_sleeps_everywhere_ends(
    cache: Path, monkeypatch: pytest.MonkeyPatch, sessions: list[str]
) -> None:
    """Once its budget is spent, nothing more of it is run, nor run again; the cause is told."""
    monkeypatch.setitem(budget.SECONDS, ASLEEP, 1.0)
    bodies = dict.fromkeys(STUDENT_MAIN, NAP.format(700_000))
    results = judge({"main.c": main_c({**STUDENT_MAIN, **bodies})}, cache, tp=1)
    told = [each for each in results.values() if each.outcome == "timeout"]
    assert len(told) > len(results) // 2
    assert all(each.points == 0 for each in results.values())
    assert any("waits without computing, for 1 s in all" in each.message for each in told)
    assert len(sessions) < 8


@pytest.mark.long
def test_who_loops_everywhere_is_ended_sooner(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The seconds that are told are those that the call had."""
    monkeypatch.setattr(budget, "LOOPS", 1)
    bodies = dict.fromkeys(("fill_red", "fill_rect"), "for (volatile int k = 1; k;) { }")
    results = judge({"main.c": main_c({**STUDENT_MAIN, **bodies})}, cache, tp=1)
    told = [each.message for each in results.values() if each.outcome == "timeout"]
    assert any("2 s of" in each for each in told)
    assert any("1 s of" in each for each in told)


def test_a_constructor_that_sleeps_costs_its_seconds_once(
    cache: Path, monkeypatch: pytest.MonkeyPatch, sessions: list[str]
) -> None:
    """Each session would wait for it again; what calls what waits without end waits for that."""
    monkeypatch.setitem(budget.SECONDS, ASLEEP, 1.0)
    nap = "extern int usleep(unsigned);\n"
    nap += "__attribute__((constructor)) static void c(void) { usleep(700000); }\n"
    results = judge({"main.c": main_c(STUDENT_MAIN) + nap}, cache, tp=1)
    told = [each.outcome for each in results.values()]
    assert set(told) <= {"timeout", "passed", "blocked"}
    assert "timeout" in told
    assert len(sessions) < 8
