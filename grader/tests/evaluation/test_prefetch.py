"""Pictures drawn beside the other checks: which, when, and in what order."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from queue import Queue

import pytest

from grader.course import exercises
from grader.course.exercises import Manifest
from grader.evaluation.prefetch import Prefetch, RunResult
from grader.evaluation.records import Outcome

SECONDS = 30  # a test that waits longer is stuck
FLAT, BETWEEN, LAST = "tp2.scene.flat_0", "tp4.scene.mirror_0", "tp5.scene.smooth_4"
DONE = RunResult(None, 1.0)


@pytest.fixture
def rules() -> Manifest:
    """Return the course's own manifest."""
    return exercises.load()


def needed(rules: Manifest, picture: str, checks: list[str]) -> list[str]:
    """Return the checks of functions that a picture waits for."""
    known = rules.checks()
    wanted = {*rules.needed(known[picture]), known[picture].exercise}
    return [
        each for each in checks if not known[each].is_picture and known[each].exercise in wanted
    ]


class Drawing:
    """What stands for running a check: it is noted, and goes on when it may."""

    def __init__(self) -> None:
        self.begun: Queue[str] = Queue()
        self.may_end = threading.Event()

    def __call__(self, check: str) -> RunResult:
        """Be run."""
        self.begun.put(check)
        assert self.may_end.wait(SECONDS)
        return DONE


@pytest.fixture
def drawing() -> Iterator[Drawing]:
    """Return what is run ahead; it ends with the test."""
    made = Drawing()
    yield made
    made.may_end.set()


def test_pictures_come_last_and_what_they_wait_for_first(rules: Manifest, drawing: Drawing) -> None:
    """TP1's functions, which no picture needs, and what only a bonus needs, come between."""
    checks = [*rules.checks()]
    ahead = Prefetch(rules, drawing)
    order = ahead.order(checks)
    ahead.close()
    assert sorted(order) == sorted(checks)
    drawn = [each for each in checks if rules.checks()[each].is_picture]
    assert order[-len(drawn) :] == drawn
    place = {name: number for number, name in enumerate(order)}
    assert place["tp5.pixel_color.mean"] < place["tp2.intersect_cylinder.meets"]
    assert place["tp2.intersect_cylinder.meets"] < place["tp1.fill_red.every_pixel"]


def test_a_picture_is_drawn_when_all_that_it_needs_has_passed(
    rules: Manifest, drawing: Drawing
) -> None:
    """Not before, and its result is there for its turn."""
    ahead = Prefetch(rules, drawing)
    *others, last = needed(rules, FLAT, [*rules.checks()])
    ahead.order([*others, last, FLAT])
    for name in others:
        ahead.heard(name, Outcome.PASSED)
    assert drawing.begun.empty()
    ahead.heard(last, Outcome.PASSED)
    assert drawing.begun.get(timeout=SECONDS) == FLAT
    drawing.may_end.set()
    assert ahead.result(FLAT) == DONE
    ahead.close()


@pytest.mark.parametrize("outcome", [Outcome.TIMEOUT, Outcome.TODO, Outcome.FAILED])
def test_what_needs_something_wrong_is_never_drawn_ahead(
    rules: Manifest, drawing: Drawing, outcome: Outcome
) -> None:
    """It is run in its turn, when what loops is known."""
    ahead = Prefetch(rules, drawing)
    ahead.order([*rules.checks()])
    first, *others = needed(rules, FLAT, [*rules.checks()])
    ahead.heard(first, outcome)
    for name in others:
        ahead.heard(name, Outcome.PASSED)
    assert ahead.result(FLAT) is None
    ahead.close()
    assert drawing.begun.empty()


def test_two_threads_draw_from_either_side(rules: Manifest, drawing: Drawing) -> None:
    """The last picture is drawn ahead; the first, in its turn, is not while that one lasts."""
    ahead = Prefetch(rules, drawing)
    assert ahead.order([FLAT, BETWEEN, LAST]) == [FLAT, BETWEEN, LAST]  # nothing to wait for
    assert drawing.begun.get(timeout=SECONDS) == LAST
    assert ahead.result(FLAT) is None
    drawing.may_end.set()
    assert drawing.begun.get(timeout=SECONDS) == BETWEEN
    assert [ahead.result(name) for name in (BETWEEN, LAST)] == [DONE, DONE]
    ahead.close()
    assert drawing.begun.empty()


def test_as_many_pictures_are_drawn_at_once_as_there_are_threads(
    rules: Manifest, drawing: Drawing
) -> None:
    """The last ones; with none, nothing is drawn ahead."""
    ahead = Prefetch(rules, drawing, threads=2)
    ahead.order([FLAT, BETWEEN, LAST])
    assert {drawing.begun.get(timeout=SECONDS) for _ in range(2)} == {BETWEEN, LAST}
    assert ahead.result(FLAT) is None
    drawing.may_end.set()
    assert [ahead.result(name) for name in (BETWEEN, LAST)] == [DONE, DONE]
    ahead.close()
    alone = Prefetch(rules, drawing, threads=0)
    alone.order([FLAT, LAST])
    assert [alone.result(name) for name in (FLAT, LAST)] == [None, None]
    alone.close()
    assert drawing.begun.empty()
