"""A loop costs what loops, and each sentence names a call that did not come back."""

from __future__ import annotations

from pathlib import Path

from grader.evaluation.records import Outcome
from grader.execution.loops import LOOPS, Loop, Loops
from grader.execution.records import Cause, Death
from grader.tests.support.judging import judge, solution

RECTANGLE = "    int i1 = pixel_of(p1.x, WIDTH);\n"
FOREVER = "    for (volatile int k = 1; k;) {\n    }\n"
FIRST, SECOND = (Loop(Death(Cause.TIMEOUT), f"fill({each})", "") for each in (1, 2))


def told(files: dict[str, str], cache: Path) -> dict[str, tuple[Outcome, str]]:
    """Return what comes of the checks of the rectangle, and the call that each tells of."""
    checks = judge(files, cache, 1, "fill_rect")
    return {
        name.rpartition(".")[2]: (each.outcome, each.message.partition(" does not end")[0])
        for name, each in checks.items()
    }


def test_a_loop_on_some_arguments_does_not_cost_the_others(cache: Path) -> None:
    """A rectangle that never ends when its corners are exchanged is right otherwise."""
    files = solution()
    loop = FOREVER.replace("k = 1", "k = p1.x > p2.x")
    files["main.c"] = files["main.c"].replace(RECTANGLE, loop + RECTANGLE)
    found = told(files, cache)
    outcomes = {name: outcome for name, (outcome, _) in found.items()}
    assert outcomes == {
        "inside": Outcome.PASSED,
        "fractions": Outcome.PASSED,
        "corner_order": Outcome.TIMEOUT,
        "clipped": Outcome.PASSED,
        "off_screen": Outcome.PASSED,
    }


def test_what_always_loops_is_called_once_and_told_by_that_call(cache: Path) -> None:
    """The other checks tell the call that was made, not their own, which was not."""
    files = solution()
    files["main.c"] = files["main.c"].replace(RECTANGLE, FOREVER + RECTANGLE)
    found = told(files, cache)
    assert {outcome for outcome, _ in found.values()} == {Outcome.TIMEOUT}
    assert len({call for _, call in found.values()}) == 1


def test_a_second_chance_is_for_who_has_come_back() -> None:
    """And pictures, which take long, have none."""
    loops = Loops()
    assert loops.of("fill") is None
    loops.add("fill", FIRST)
    assert loops.of("fill") == FIRST
    loops.come_back("fill")
    assert loops.of("fill") is None
    assert loops.of("fill", chances=1) == FIRST
    loops.add("fill", SECOND)
    assert LOOPS == 2
    assert loops.of("fill") == SECOND
