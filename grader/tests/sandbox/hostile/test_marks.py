"""Hostile files beside right ones: the mark is given, and is the right one's or none of it."""

from __future__ import annotations

from pathlib import Path

import pytest

from grader.authoring.specimens.student import STUDENT_MAIN, main_c
from grader.tests.support.judging import judge

WHOLE = 1500
SHOUT = """
#include <string.h>
#include <unistd.h>
__attribute__((constructor)) static void shout(void) {
    static char text[20000];
    memset(text, ':', sizeof text);
    (void)!write(2, text, sizeof text);
    (void)!write(1, text, sizeof text);
    _exit(3);
}
"""
KILL = """
#include <signal.h>
#include <unistd.h>
__attribute__((constructor)) static void end(void) { kill(getpid(), SIGKILL); }
"""
# What lies beside a right main.c, and the points.
BESIDE = {
    "a warning in the sandbox's name": ('#line 1 "bwrap"\nvoid f(void) { int x; }\n', WHOLE),
    "an error in the sandbox's name": ('#line 1 "bwrap"\nvoid f(void) { x }\n', WHOLE),
    "the assembler in its name": ('__asm__(".warning \\"x\\\\nbwrap: killed\\"");\n', WHOLE),
    "a killed compiler, told": ('#error "Killed signal terminated program cc1"\n', WHOLE),
    "a shout that patterns go back over": (SHOUT, 0),
    "a process that kills itself while loading": (KILL, 0),
    "an exit that looks like success": (SHOUT.replace("_exit(3)", "_exit(0)"), 0),
}


@pytest.mark.parametrize("name", BESIDE)
def test_a_mark_is_given_and_is_the_submission_s(name: str, cache: Path) -> None:
    """The machine is never made guilty: nothing is left open, and nothing gained."""
    text, points = BESIDE[name]
    results = judge({"main.c": main_c(STUDENT_MAIN), "beside.c": text}, cache, 1, "tp1")
    assert sum(each.points for each in results.values()) == points
    assert "error" not in {each.outcome.value for each in results.values()}
