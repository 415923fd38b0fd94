"""A process that serves several checks: each finds it as the first did."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from grader.execution.records import Limits
from grader.execution.session import Died, Library, Session, open_core
from grader.execution.worker_process import Overdrawn

Write = Callable[..., Path]
SHORT = Limits(cpu=1)
PIXELS = np.zeros((96 * 64, 3), np.float32)
WHO = "extern int getpid(void); img[0] = vector_init((float)getpid(), 0, 0);"
COUNTING = """
    extern int rand(void);
    static int calls;
    static int *kept;
    if (kept == NULL)
        kept = calloc(1, sizeof *kept);
    img[0] = vector_init((float)++calls, (float)++*kept, (float)(rand() % 1000));
"""


def first_pixel(s: Session, name: str = "fill_red") -> list[float]:
    """Call a function that draws; return the first pixel."""
    rest = [(0, 0, 0)] if name == "fill" else []
    reply = s.call(name, PIXELS, *rest)
    pixel: list[float] = reply.args["img"][0].tolist()
    return pixel


def draw_thrice(s: Session) -> None:
    """Call a function three times."""
    for _ in range(3):
        s.call("fill_red", PIXELS)


def served(core: Library, times: int = 2, name: str = "fill_red") -> list[list[float]]:
    """Return the first pixel of so many checks."""
    found = []
    for _ in range(times):
        with core.lent(SHORT) as s:
            found.append(first_pixel(s, name))
    return found


@pytest.mark.parametrize("sanitized", [True, False])
def test_one_process_serves_with_variables_as_at_first(
    submission: Write, cache: Path, sanitized: bool
) -> None:
    """Static variables, what they point to, globals and random numbers begin again."""
    folder = submission(fill_red=COUNTING, fill=WHO)
    with open_core(folder, 96, 64, sanitized=sanitized, cache=cache) as core:
        first, second = served(core)
        assert first[:2] == [1, 1]
        assert second == first
        one, other = served(core, name="fill")
        assert one == other
        with core.lent(SHORT) as s:
            s.set("num_lights", 2)
            s.set("output_image", PIXELS + 1)
            assert s.get("num_lights") == 2
        with core.lent(SHORT) as s:
            assert s.get("num_lights") == 0
            assert s.get("output_image").max() == 0


def test_what_a_check_printed_and_marked_is_its_own(submission: Write, cache: Path) -> None:
    """The next one sees neither the words nor the markers, nor what was written to no answer."""
    folder = submission(fill_red='puts("hello"); MRT_TODO("TP1.1");')
    with open_core(folder, 96, 64, cache=cache) as core:
        with core.lent(SHORT) as s:
            s.call("fill_red", PIXELS)
            assert "hello" in s.output()
            marks = s.todo()
            s.set("num_lights", 3)
        with core.lent(SHORT) as s:
            assert (s.output(), s.todo()) == ("", frozenset())
            assert s.get("num_lights") == 0
    assert marks == frozenset({"TP1.1"})


def test_a_thread_s_variables_cannot_be_put_back(submission: Write, cache: Path) -> None:
    """Such a library gets a new process each time."""
    folder = submission(fill_red="static _Thread_local int calls; img[0].x = (float)++calls;")
    with open_core(folder, 96, 64, cache=cache) as core:
        assert [each[0] for each in served(core, 3)] == [1, 1, 1]


def test_who_dies_is_not_lent_again(submission: Write, cache: Path) -> None:
    """A crash ends the process; the next check has another, and knows nothing of it."""
    with open_core(submission(fill="abort();", fill_red=WHO), 96, 64, cache=cache) as core:
        ((before, *_),) = served(core, 1)
        with pytest.raises(Died), core.lent(SHORT) as s:
            s.call("fill", PIXELS, (0, 0, 0))
        ((after, *_),) = served(core, 1)
    assert before != after


def test_one_check_has_its_own_seconds(submission: Write, cache: Path) -> None:
    """Each has all of them, whatever the others took; who takes more is told, or ended."""
    busy = "clock_t end = clock() + CLOCKS_PER_SEC * {} / 10; while (clock() < end) {{ }}"
    folder = submission(
        fill_red=busy.format(4),
        fill="for (volatile int k = 0;; k ^= 1) { }",
        files={"raytracer.h": '#include "exercises.h"\n#include <time.h>\n'},
    )
    with open_core(folder, 96, 64, cache=cache) as core:
        for _ in range(3):
            with core.lent(SHORT) as s:
                s.call("fill_red", PIXELS)
        with pytest.raises(Overdrawn), core.lent(SHORT) as s:
            draw_thrice(s)
        with pytest.raises(Died), core.lent(SHORT) as s:
            s.call("fill", PIXELS, (0, 0, 0))
