"""Who does without the options, as the handout allows, keeps the points of functions."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

from grader.build import substitution
from grader.course import exercises
from grader.tests.support.judging import judge, solution

# Everything in trace_ray, whatever hit_color would do at the stage.
WHOLE = {
    "return hit_color(r, &it);": """vec3 v = vector_normalized(vector_float_mul(-1.f, r->dir));
        if (it.mat.refraction_index > 0.f) return glass_color(r, &it);
        return vector_add(direct_light(&it, v), mirror_color(r, &it));"""
}
SWITCHES = {"if (options.fresnel)": "if (true)", "if (options.shadows && ": "if ("}
SOONER = {"r->depth > options.max_depth": "r->depth >= options.max_depth"}
CONSTANTS = {"options.max_depth": "10", "options.epsilon": "EPSILON"}


def lost(changes: Mapping[str, str], cache: Path) -> dict[str, str]:
    """Return the checks of functions that the reference does not pass with these changes."""
    files = solution()
    for old, new in changes.items():
        assert old in files["raytracer.c"], old
        files["raytracer.c"] = files["raytracer.c"].replace(old, new)
    functions = [
        name
        for name, each in exercises.load().checks().items()
        if not (each.is_picture or name[:3] == "tp1")
    ]
    found = judge(files, cache, chosen=functions)
    return {each.id: each.message for each in found.values() if each.outcome.value != "passed"}


@pytest.mark.long
@pytest.mark.parametrize(
    "changes",
    [SWITCHES, {**WHOLE, **CONSTANTS}, {**WHOLE, **SWITCHES}, {**WHOLE, **SOONER}],
    ids=["switches", "whole", "both", "sooner"],
)
def test_ignored_options_cost_no_point(
    changes: Mapping[str, str], cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Answers with the later features on are accepted, without the reference's help."""
    monkeypatch.setattr(substitution, "is_possible", lambda: False)
    assert lost(changes, cache) == {}


@pytest.mark.long
def test_a_wrong_colour_is_wrong_with_all_features_too(cache: Path) -> None:
    """The second way of being right is no way round the check."""
    dimmed = {"return hit_color(r, &it);": "return vector_float_mul(0.9f, hit_color(r, &it));"}
    assert "tp2.trace_ray.object" in lost(dimmed, cache)
