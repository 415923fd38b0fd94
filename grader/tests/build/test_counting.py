"""The check that counts how many objects a ray is tested against."""

from __future__ import annotations

from pathlib import Path

import pytest

from grader.evaluation.records import CheckResult
from grader.tests.support.judging import judge, solution

CHECK = "tp4.octree.fewer_tests"
LIST = """
static bool test(ray *r, intersection *it, const object *obj) { return CALLED(r, it, obj); }
bool octree_intersect(const octree_node *node, ray *r, intersection *it) {
    (void)node;
    bool hit = false;
    for (int k = 0; k < object_count; k++) {
        if (scene[k].type != PLANE && test(r, it, &scene[k])) {
            hit = true;
        }
    }
    return hit;
}
"""
# A sphere of the student's own, which no count sees.
OWN = """
static bool own_sphere(ray *r, intersection *it, const object *obj) {
    vec3 o = vector_minus(r->orig, obj->center);
    float a = vector_sqnorm(r->dir), b = vector_dot(o, r->dir);
    float c = vector_sqnorm(o) - obj->radius * obj->radius;
    float d = b * b - a * c;
    if (d < 0.f) return false;
    float t = (-b - sqrtf(d)) / a;
    if (t < r->tmin) t = (-b + sqrtf(d)) / a;
    if (t < r->tmin || t > r->tmax) return false;
    r->tmax = t;
    it->position = ray_at(*r, t);
    it->normal = vector_normalized(vector_minus(it->position, obj->center));
    it->mat = obj->mat;
    return true;
}
"""


def counted(called: str, cache: Path) -> CheckResult:
    """Judge an octree_intersect that goes through the list by a function of that name."""
    files = solution()
    own, _, rest = files["octree.c"].partition("bool octree_intersect(")
    after = rest[rest.index("\n}\n") + 3 :]
    files["octree.c"] = own + OWN + LIST.replace("CALLED", called) + after
    return judge(files, cache, 4, "octree.hits or octree.fewer_tests")[CHECK]


@pytest.mark.parametrize("called", ["intersect_object", "intersect_sphere"])
def test_the_whole_list_is_no_tree(called: str, cache: Path) -> None:
    """Right answers by testing everything earn nothing here, whichever way objects are tested."""
    found = counted(called, cache)
    assert (found.outcome.value, found.points) == ("failed", 0)
    assert "tests 200 of them per ray; 100 at most are expected" in found.message


def test_tests_that_no_count_sees_earn_nothing(cache: Path) -> None:
    """Going round the functions of the exercises is told as such."""
    found = counted("own_sphere", cache)
    assert (found.outcome.value, found.points) == ("failed", 0)
    assert "were called 0 times only" in found.message


def test_the_reference_tests_few(cache: Path) -> None:
    """The tree of the solution has the points."""
    found = judge(solution(), cache, 4, "octree.hits or octree.fewer_tests")[CHECK]
    assert (found.outcome.value, found.points) == ("passed", found.max_points)
