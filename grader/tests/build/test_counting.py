"""The check that counts how many objects a ray is tested against."""

from __future__ import annotations

from pathlib import Path

import pytest

from grader.authoring.specimens import variants
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


def counted(called: str, cache: Path, listing: str = LIST, before: str = "") -> CheckResult:
    """Judge an octree_intersect that goes through the list by a function of that name."""
    files = solution()
    own, _, rest = files["octree.c"].partition("bool octree_intersect(")
    after = rest[rest.index("\n}\n") + 3 :]
    files["octree.c"] = before + own + OWN + listing.replace("CALLED", called) + after
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


# The nearest object is found unseen; then it alone is tested, as if by a tree.
TWICE = """
@BEFORE@
bool octree_intersect(const octree_node *node, ray *r, intersection *it) {
    (void)node;
    int best = -1;
    for (int k = 0; k < object_count; k++) {
        ray copy = *r;
        intersection seen = {0};
        if (scene[k].type == SPHERE && @TEST@) {
            best = k;
            r->tmax = copy.tmax;
        }
    }
    if (best < 0) return false;
    r->tmax *= 1.0001f;
    return intersect_sphere(r, it, &scene[best]);
}
"""
COPIED = TWICE.replace("@TEST@", "own_sphere(&copy, &seen, &scene[k])")
HIDDEN = "#define PASTE(a, b) a##b\n__attribute__((PASTE(no_sanitize_, coverage), "
HIDDEN += "PASTE(no_instrument_, function)))"
RESET = """
uint64_t mrt_object_tests(void);
static bool forgetting(ray *r, intersection *it, const object *obj) {
    bool hit = intersect_sphere(r, it, obj);
    mrt_object_tests();
    return hit;
}
"""
CHEATS = {
    "a copy under another name, and one counted test": COPIED.replace("@BEFORE@", ""),
    "the same, hidden": COPIED.replace("@BEFORE@", HIDDEN),
    "the counter asked for, to forget": RESET + LIST.replace("CALLED", "forgetting"),
    "a counter of one's own": "uint64_t mrt_object_tests(void);\n"
    "uint64_t mrt_object_tests(void) { static uint64_t k; return k += 600; }\n"
    + LIST.replace("CALLED", "intersect_object"),
    "another name by a macro": "static bool own_sphere(ray *, intersection *, const object *);\n"
    "#define intersect_sphere own_sphere\n" + LIST.replace("CALLED", "intersect_sphere"),
}


@pytest.mark.parametrize("cheat", CHEATS)
def test_no_count_is_cheated(cheat: str, cache: Path) -> None:
    """The whole list, tested for each ray, whatever it is called and whoever counts."""
    found = counted("", cache, CHEATS[cheat], "#include <stdint.h>\n")
    assert (found.outcome.value, found.points) == ("failed", 0), found.message


@pytest.mark.parametrize("patch", ["octree_by_boxes", "octree_small_leaves", "bvh"])
def test_other_trees_test_few(patch: str, cache: Path) -> None:
    """Right programs that are written otherwise have the points."""
    (variant,) = [each for each in variants.load() if each.id == patch]
    found = judge(variant.files(), cache, 4, "octree.hits or octree.fewer_tests")[CHECK]
    assert (found.outcome.value, found.points) == ("passed", found.max_points)


def test_the_reference_tests_few(cache: Path) -> None:
    """The tree of the solution has the points."""
    found = judge(solution(), cache, 4, "octree.hits or octree.fewer_tests")[CHECK]
    assert (found.outcome.value, found.points) == ("passed", found.max_points)
