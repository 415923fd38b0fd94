"""One idea is paid where it is asked, and what is no work earns nothing beside it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from grader.authoring.specimens import cases
from grader.evaluation.records import Outcome
from grader.tests.support.judging import judge, solution

BLACK = "vector_init(0.f, 0.f, 0.f)"
SIDE = "vector_dot(it->normal, v) < 0.f ? vector_float_mul(-1.f, it->normal) : it->normal"

# By name: a line of the solution and what stands in its place; the checks, and those that fail.
IDEAS = {
    "mirror without a coefficient": (
        *("return vector_vec_mul(k, trace_ray(&reflected));", "return trace_ray(&reflected);"),
        *("tp4.mirror_color", {"sky", "channels"}),
    ),
    "camera half a pixel too far": (
        *("camera_ray(ray *r, float x, float y) {", "{old}\n    x += 0.5f;\n    y += 0.5f;"),
        *("tp2.camera_ray", {"exact", "middle"}),
    ),
    "small spheres passed by": (
        *("if (!(rest >= 0.f)) {", "if (!(rest * d_d >= 2.5e-3f)) {"),
        *("tp2.intersect_sphere", {"meets"}),
    ),
    "light on the eye's side": (
        *("shade(it->normal, v, l,", f"shade({SIDE}, v, l,"),
        *("tp3.direct_light", {"behind"}),
    ),
    "Fresnel in the mirror by a direction that is not unit": (
        "vec3 v = vector_normalized(vector_float_mul(-1.f, in->dir));\n        k =",
        "vec3 v = vector_float_mul(-1.f, in->dir);\n        k =",
        *("tp5.fresnel_use", {"unit"}),
    ),
    "spheres counted from one call to the next": (
        *(
            "if (!add_object(init_sphere(",
            "static int made;\n    if (++made > 40 || !add_object(init_sphere(",
        ),
        *("tp5.populate_spheres", {"count", "full"}),
    ),
}

# By function: a body that computes nothing of what is asked, and the checks that fail with it.
NO_WORK = {
    "shade": (
        f"return vector_dot(n, l) <= 0.f ? {BLACK} : vector_vec_mul(light_color, mat->kd);",
        *("tp3.shade", {"diffuse", "lobe", "both", "back", "far_lobe", "shininess", "bright"}),
    ),
    "direct_light": (
        f"color sum = {BLACK};\n    for (int k = 0; k < num_lights; k++) {{\n"
        "        sum = vector_add(sum, vector_vec_mul(it->mat.kd, lights[k].col));\n    }\n"
        "    return sum;",
        *("tp3.direct_light", {"one", "sum", "bright", "none", "count", "barred", "behind"}),
    ),
    "mirror_color": (
        "return vector_vec_mul(it->mat.ks, sky_color());",
        *("tp4.mirror_color", {"sky", "object", "depth", "alone", "channels", "bright"}),
    ),
    "fresnel_schlick": (
        "return vector_dot(n, v) > 0.5f ? kr : vector_init(1.f, 1.f, 1.f);",
        *("tp5.fresnel_schlick", {"angle", "normal", "grazing", "negative"}),
    ),
    "raytrace": (
        "for (int k = 0; k < WIDTH * HEIGHT; k++) {\n"
        f"        output_image[k] = k % 2 ? {BLACK} : sky_color();\n    }}",
        *("tp2.raytrace", {"colors", "centre", "every_pixel"}),
    ),
    "intersect_plane": (
        "r->tmax = 3.f;\n    it->position = ray_at(*r, 3.f);\n    it->normal = obj->normal;\n"
        "    it->mat = obj->mat;\n    return true;",
        "tp2.intersect_plane",
        {"meets", "distance", "position", "normal", "material", "scaled", "range", "behind"}
        | {"grazing", "parallel", "miss", "only"},
    ),
}


def failing(files: dict[str, str], cache: Path, checks: str) -> set[str]:
    """Return which checks of functions do not pass, without the exercise's name."""
    judged = judge(files, cache, None, f"{checks}.")
    assert judged
    return {
        name.rpartition(".")[2] for name, each in judged.items() if each.outcome != Outcome.PASSED
    }


@pytest.mark.parametrize("name", IDEAS)
def test_one_idea_is_paid_where_it_is_asked(name: str, cache: Path) -> None:
    """And not in every check that its answers enter."""
    old, new, checks, expected = IDEAS[name]
    files = solution()
    (file,) = (each for each, text in files.items() if text.count(old) == 1)
    files[file] = files[file].replace(old, new.replace("{old}", old))
    assert failing(files, cache, checks) == expected


@pytest.mark.long
@pytest.mark.parametrize("function", NO_WORK)
def test_what_is_no_work_earns_nothing(function: str, cache: Path) -> None:
    """Nor at the edges, where a constant is right."""
    body, checks, expected = NO_WORK[function]
    files = solution()
    head = re.compile(rf"^[a-z]+ {function}\([^;]*?\) \{{\n", re.MULTILINE)
    files["raytracer.c"], count = _with_body(files["raytracer.c"], head, body)
    assert count == 1
    assert failing(files, cache, checks) == expected


def _with_body(text: str, head: re.Pattern[str], body: str) -> tuple[str, int]:
    found = list(head.finditer(text))
    start = found[0].end()
    end = text.index("\n}\n", start)
    return text[:start] + "    " + body + text[end:], len(found)


@pytest.mark.long
def test_lights_given_up_are_told_from_those_asked_about_wrongly(cache: Path) -> None:
    """Who asks about the first light for each of them is not told to return black at a shadow."""
    loop = "in_shadow(it, &lights[k])) {\n            "
    edits = {
        "return black": (f"{loop}continue;", f"{loop}return {BLACK};"),
        "the first light": ("in_shadow(it, &lights[k])", "in_shadow(it, lights)"),
        "return the sum": (f"{loop}continue;", f"{loop}return sum;"),
        "the last light": ("in_shadow(it, &lights[k])", "in_shadow(it, &lights[num_lights - 1])"),
    }
    named = {}
    for name, (old, new) in edits.items():
        files = solution()
        assert files["raytracer.c"].count(old) == 1
        files["raytracer.c"] = files["raytracer.c"].replace(old, new)
        judged = judge(files, cache, None, "tp3.direct_light.")["tp3.direct_light.barred"]
        assert judged.outcome is Outcome.FAILED
        named[name] = judged.mistakes
    assert named == {
        "return black": ("shadow_darkens_all",),
        "the first light": (),
        "return the sum": (),
        "the last light": (),
    }


def test_the_seed_of_glass_is_not_charged_with_a_mirror(cache: Path) -> None:
    """What glass is surrounded by mirrors as well: by Fresnel, of which the direction is wrong."""
    files = solution()
    old = "vector_normalized(vector_float_mul(-1.f, in->dir));\n        k ="
    assert files["raytracer.c"].count(old) == 1
    files["raytracer.c"] = files["raytracer.c"].replace(old, "in->dir;\n        k =")
    judged = judge(files, cache, None, "tp5.fresnel_use.mirror or tp5.glass_color.seed")
    outcomes = {name: each.outcome for name, each in judged.items()}
    assert outcomes == {
        "tp5.fresnel_use.mirror": Outcome.FAILED,
        "tp5.glass_color.seed": Outcome.PASSED,
    }


def test_a_tree_of_ten_cuts_is_right(cache: Path) -> None:
    """It stops by its depth alone, as the handout says, however many spheres coincide."""
    (case,) = (each for each in cases.load() if each.id == "octree_of_ten_levels")
    assert failing(case.files(), cache, "tp4.octree") == set()
