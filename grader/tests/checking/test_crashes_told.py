"""A crash as a student reads it, from a submission to the sentence, the line and the question."""

from __future__ import annotations

from pathlib import Path

from grader.tests.support.judging import judge, solution

SCENE = "intersect_object(r, it, &scene[k])"


def test_a_right_function_called_badly_is_not_accused(cache: Path) -> None:
    """The calls are told, and the line shown is the judged function's; the question is a crash's.

    The question of the check, on what the function computes, would lead astray.
    """
    files = solution()
    source = files["raytracer.c"]
    assert SCENE in source
    files["raytracer.c"] = source.replace(SCENE, SCENE.replace("it,", "NULL,"))
    line = source[: source.index(SCENE)].count("\n") + 1
    crashed = judge(files, cache, 2, "intersect_scene")["tp2.intersect_scene.meets"]
    assert crashed.location == f"raytracer.c:{line}"
    assert "in record_hit (raytracer.c:" in crashed.message
    assert f"called by intersect_scene ({line})" in crashed.message
    assert crashed.hint.startswith("Which pointer of this line may be NULL")
