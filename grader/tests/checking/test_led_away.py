"""Sentences and questions that led away from the mistake: none is given for it any more."""

from __future__ import annotations

from pathlib import Path

import pytest

from grader.evaluation.records import CheckResult
from grader.tests.support.judging import judge, solution

RETURNS = "    return hit;\n    /* END SOLUTION */\n}\n\n/* TP2.6"
SHADE = "shade(it->normal, v, l, lights[k].col, &it->mat)"
TO_LIGHT = "vector_minus(lights[k].position, it->position)"
OUTWARDS = "vector_normalized(outwards)"
VIEWER = f"vector_float_mul(vector_dot(outwards, r->dir) > 0.f ? -1.f : 1.f, {OUTWARDS})"
FIRST = "vector_add(it->position, vector_float_mul(options.epsilon, dir))"
WRITTEN = f"out->orig = {FIRST}; out->dir = dir; out->tmax = 1000.f;"
SLOPE = "float slope = vector_dot(r->dir, obj->normal)"
# By its name: what is changed in the solution, the check that fails, what its message says and
# what is asked, and what led away from it.
CASES = {
    "depth limit": (
        [("r->depth > options.max_depth", "r->depth >= 5")],
        "tp2.trace_ray.depth",
        "Only the rays of depth 6 or more are wrong.",
        "From which depth on is your ray black?",
        "What do you do with it when nearest_hit returns true?",
    ),
    "true for a miss": (
        [(RETURNS, RETURNS.replace("hit", "hit || r->tmax > 0.f"))],
        "tp2.intersect_scene.nothing",
        "returns true; false is expected.",
        "What does your function return when none of the objects is hit",
        "What do r and it hold after a call that returns false?",
    ),
    "normal turned to the viewer": (
        [(OUTWARDS, VIEWER)],
        "tp2.intersect_sphere.from_inside",
        "Each time, what comes is the opposite of what is expected.",
        "Which way is outside when the ray starts inside?",
        "From inside, what are the signs of the two t?",
    ),
    "position": (
        [("it->position = ray_at(*r, t)", "it->position = vector_init(0.f, 0.f, 0.f)")],
        "tp2.intersect_sphere.position",
        "it->position is (0, 0, 0)",
        "On which parameters does your answer depend, and on which ones should it?",
        "What is a = dir.dir here?",
    ),
    "a light that fades": (
        [(SHADE, f"vector_float_mul(1.f / vector_sqnorm({TO_LIGHT}), {SHADE})")],
        "tp3.direct_light.one",
        "the three channels are right but for one common factor, which is not always the same",
        "By what do you multiply, or divide, the whole colour",
        "What is the direction from the point to the light, and how long is it?",
    ),
    "whole number": (
        [("out->seed = in->seed", "out->seed = 1")],
        "tp4.reflected_ray.fresh",
        "out->seed is 1; ",
        "Which seed does the reflected ray go on with?",
        "e+09",
    ),
    "a state that is kept": (
        [(SLOPE, f"static int calls = 0; {SLOPE} * (++calls > 4 ? 2.f : 1.f)")],
        "tp2.intersect_plane.distance",
        "Made alone, the same call gives the right answer",
        "Which static or global variable does your function write",
        "What is the t that you compute, and where do you write it?",
    ),
    "a field that is not written": (
        [
            (
                f"ray_init(out, {FIRST}, dir);",
                WRITTEN,
            )
        ],
        "tp4.reflected_ray.fresh",
        "out->tmin has not been written; 0 is expected.",
        "From which t on does the reflected ray look?",
        "-77",
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_the_question_follows_what_is_wrong(name: str, cache: Path) -> None:
    """The message says how it is wrong, the question is about that."""
    changes, check, message, question, away = CASES[name]
    files = solution()
    for old, new in changes:
        assert old in files["raytracer.c"]
        files["raytracer.c"] = files["raytracer.c"].replace(old, new, 1)
    result = judged(files, cache, check)
    assert message in result.message
    assert question in result.hint
    assert away not in result.message + result.hint


def judged(files: dict[str, str], cache: Path, check: str) -> CheckResult:
    """Return what becomes of a check, among those of its function."""
    return judge(files, cache, keyword=check.rpartition(".")[0])[check]
