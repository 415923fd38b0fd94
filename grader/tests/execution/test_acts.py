"""What isolation may refuse is noted, with its place, and told in words."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from grader.course.message import Message
from grader.course.texts import LANGUAGES, Texts
from grader.evaluation.outcomes import remarks_on, told_with_acts
from grader.evaluation.records import Outcome
from grader.execution import death_messages
from grader.execution.records import Act
from grader.execution.session import open_core
from grader.sandbox.levels import IsolationError, Level, using
from grader.worker import frames

Write = Callable[..., Path]
PIXELS = np.zeros((96 * 64, 3), np.float32)
# Where the network is away, a socket of the machine's own is refused as well.
ACTS = {
    "fill_red": (
        "thread",
        "pthread_t one; if (pthread_create(&one, NULL, same, img) == 0) pthread_join(one, NULL);",
    ),
    "fill": (
        "process",
        "(void)c; pid_t child = fork(); if (child == 0) _exit(0);"
        " if (child > 0) wait(NULL); img[0].x = 1;",
    ),
    "horizontal_gradient": (
        "file",
        "(void)c1; (void)c2; img[0].x = 1;"
        ' FILE *log = fopen("/dev/null", "r+"); if (log != NULL) fclose(log);',
    ),
    "fill_circle": (
        "network",
        "(void)img; (void)radius; (void)center; (void)c;"
        " int end = socket(AF_UNIX, SOCK_STREAM, 0); if (end >= 0) close(end);",
    ),
}
HEAD = """
#include <pthread.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
static void *same(void *data) { return data; }
void fill_red"""
ARGUMENTS = {
    "fill_red": (),
    "fill": ((0, 0, 0),),
    "horizontal_gradient": ((0, 0, 0), (0, 0, 0)),
    "fill_circle": (1, (0, 0, 0), (0, 0, 0)),
}


@pytest.mark.parametrize("level", [Level.STRONG, Level.MEDIUM, Level.PORTABLE])
@pytest.mark.parametrize("sanitized", [False, True])
def test_acts_are_noted(level: Level, sanitized: bool, submission: Write, cache: Path) -> None:
    """Each kind, as it went, in its function and on its line; nothing for who tries nothing."""
    folder = submission({}, **{name: body for name, (_, body) in ACTS.items()})
    text = (folder / "main.c").read_text(encoding="utf-8").replace("void fill_red", HEAD, 1)
    (folder / "main.c").write_text(text, encoding="utf-8")
    lines = {
        name: number
        for number, line in enumerate(text.splitlines(), 1)
        for name in ACTS
        if line.startswith(f"void {name}(")
    }
    try:
        with using(level), open_core(folder, 96, 64, sanitized=sanitized, cache=cache) as core:
            for name, (kind, _) in ACTS.items():
                with core.session() as session:
                    assert session.acts() == []
                    session.call(name, PIXELS, *ARGUMENTS[name])
                    place = f"main.c:{lines[name]}"
                    assert session.acts() == [Act(kind, level is Level.PORTABLE, name, place)]
            with core.session() as session:
                session.call("fill_rect", PIXELS, (0, 0, 0), (0, 0, 0), (9, 9, 0))
                assert session.acts() == []
    except IsolationError as error:
        pytest.skip(f"{level.value}: {error.best.reason}")


def test_a_function_of_that_name_is_the_submissions(submission: Write, cache: Path) -> None:
    """A student's own open is called, and is nobody's act."""
    body = "extern int open(int); img[0] = vector_init((float)open(2), 0, 0);"
    folder = submission({"own.c": "int open(int k) { return k + 1; }\n"}, fill_red=body)
    with open_core(folder, 96, 64, cache=cache) as core, core.session() as session:
        assert session.call("fill_red", PIXELS).args["img"][0, 0] == 3
        assert session.acts() == []


WRONG = Message("compare.value")
REFUSED = {
    kind: Act(kind, worked=False, function="f", location="main.c:3") for kind in frames.KINDS[1:]
}


@pytest.mark.parametrize("kind", REFUSED)
@pytest.mark.parametrize("outcome", [Outcome.FAILED, Outcome.CRASHED, Outcome.TIMEOUT])
def test_what_was_refused_is_told(kind: str, outcome: Outcome) -> None:
    """With its place and a question; a wrong answer beside it when it may be there without it."""
    told, place = told_with_acts(outcome, WRONG, "main.c:9", [REFUSED[kind]])
    assert told is not None
    assert place == "main.c:3"
    beside = outcome is Outcome.FAILED and kind in ("file", "network")
    assert told.then == ((WRONG,) if beside else ())
    for language in LANGUAGES:
        texts = Texts(language)
        said = death_messages.told(replace(told, then=()), place, texts)
        assert "f (main.c:3)" in said
        assert death_messages.question(told, texts).endswith((" ?", "?", "."))
        assert death_messages.question(told, texts) != texts.say("ask.other")


def test_who_is_right_is_told_nothing_of_a_refusal() -> None:
    """A function that goes on without its file is right; what worked is told where it worked."""
    assert told_with_acts(Outcome.PASSED, None, "", [*REFUSED.values()]) == (None, "")
    assert told_with_acts(Outcome.FAILED, WRONG, "a.c:1", []) == (WRONG, "a.c:1")
    assert remarks_on([*REFUSED.values()]) == ()
    for each in REFUSED.values():
        (remark,) = remarks_on([replace(each, worked=True)])
        for language in LANGUAGES:
            assert "f (main.c:3)" in Texts(language).say(remark.key, **remark.values)
