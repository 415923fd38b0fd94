"""A program is judged in processes that serve several checks as it is in one for each."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

from grader.authoring.specimens.student import STUDENT_MAIN, main_c
from grader.checking.student import Student
from grader.evaluation.attempts import Attempts
from grader.tests.support.judging import judge

FILL_RED = STUDENT_MAIN["fill_red"]
# Bodies of fill_red, the first of TP1: what they do depends on what was called before.
PROGRAMS = {
    "right": FILL_RED,
    "counts_its_calls": f"static int calls; if (++calls > 2) return; {FILL_RED}",
    "right_from_the_second_on": f"static int calls; if (calls++ == 0) return; {FILL_RED}",
    "keeps_memory": f"static int *seen; if (seen) return; seen = malloc(4); {FILL_RED}",
    "crashes_later": f"static int calls; if (++calls == 3) abort(); {FILL_RED}",
    "loops_later": f"static int calls; while (calls > 1) {{ }} calls++; {FILL_RED}",
    "prints": f'puts("ici"); {FILL_RED}',
    "leaves_early": "exit(0); (void)img;",
    "not_begun": 'MRT_TODO("TP1.1"); (void)img;',
    "not_begun_and_wrong": 'MRT_TODO("TP1.1"); img[0] = vector_init(1, 1, 1);',
    "has_a_thread_s_own": f"static _Thread_local int calls; if (++calls > 2) return; {FILL_RED}",
}


def judged(body: str, cache: Path) -> Mapping[str, object]:
    """Return what became of the checks of two exercises."""
    include = '#include "raytracer.h"\n'
    files = {
        "main.c": main_c({**STUDENT_MAIN, "fill_red": body}),
        "raytracer.h": '#include "exercises.h"\n',
        "raytracer.c": include,
        "octree.c": include,
    }
    found = judge(files, cache, tp=1, keyword="fill_red or fill. or gradient")
    return {
        name: (each.outcome, each.points, each.message, each.hint, each.note)
        for name, each in found.items()
    }


@pytest.mark.parametrize("body", PROGRAMS.values(), ids=PROGRAMS.keys())
def test_the_verdict_is_that_of_processes_of_their_own(
    body: str, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Outcome, points and sentences are the same, whatever a program keeps from call to call."""
    lent = judged(body, cache)
    monkeypatch.setattr(Student, "lent", lambda self: None)
    assert judged(body, cache) == lent


def test_what_fails_is_asked_again_alone(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A right program needs no process of its own; a wrong one gets them for what is wrong."""
    alone: list[tuple[str, ...]] = []
    tried = Attempts._lent

    def noting(self: Attempts, act: object, student: Student) -> object:
        found = tried(self, act, student)  # type: ignore[arg-type]
        if found is None:
            alone.append(student.own)
        return found

    monkeypatch.setattr(Attempts, "_lent", noting)
    judged(FILL_RED, cache)
    assert alone == []
    judged("img[0] = vector_init(1, 0, 0);", cache)
    assert set(alone) == {("fill_red",)}
