"""One mistake is paid for once: what depends on it is judged among the reference's functions."""

from __future__ import annotations

import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import NoReturn

import pytest

from grader.authoring.specimens import mistakes
from grader.authoring.specimens.half_written import without
from grader.build import substitution
from grader.build.builder import Builder
from grader.build.compiler_run import BuildError
from grader.build.records import Target
from grader.build.target import MixError
from grader.checking.student import Student
from grader.course import exercises
from grader.course.message import UserError
from grader.course.sizes import sizes_for
from grader.evaluation import attribution
from grader.evaluation.records import CheckResult, Finding, Outcome
from grader.execution.libraries import Libraries
from grader.execution.worker_process import Died
from grader.intake.records import Submission
from grader.tests.support.judging import judge, solution
from grader.tests.support.sampling import sampled

RULES = exercises.load()
KNOWN = {each.id: each for each in mistakes.load()}
WRITTEN = [each.id for each in RULES.exercises if each.checks]
# These have every kind of dependence among them.
EACH = sampled(WRITTEN, ["TP2.4", "TP4.1"])


def earned(checks: Mapping[str, CheckResult]) -> int:
    """Return the sum of the points, in hundredths."""
    return sum(each.points for each in checks.values())


def outcomes(checks: Mapping[str, CheckResult], exercise: str) -> set[str]:
    """Return what became of the checks of an exercise."""
    return {each.outcome.value for each in checks.values() if each.exercise == exercise}


def lies_in(check: exercises.Check, exercise: str) -> bool:
    """Say whether a check cannot do without an exercise that is written in the same function."""
    functions = set(RULES.exercise(check.exercise).functions)
    shared = functions & set(RULES.exercise(exercise).functions)
    return exercise in RULES.needed(check) and bool(shared)


@pytest.mark.long
@pytest.mark.parametrize("exercise", EACH)
def test_an_exercise_left_out_costs_its_own_points(exercise: str, cache: Path) -> None:
    """It is to do; the others keep their points, but what is written in the same function."""
    checks = judge(without({exercise}), cache)
    inside = [each for each in RULES.checks().values() if lies_in(each, exercise)]
    lost = RULES.exercise(exercise).points + sum(each.points for each in inside)
    assert outcomes(checks, exercise) == {"todo"}
    assert earned(checks) == 12000 - lost
    others = {each.id for each in checks.values() if each.outcome.value != "passed"}
    assert others - {each.id for each in inside} == {
        each.id for each in RULES.exercise(exercise).checks
    }


@pytest.mark.long
@pytest.mark.parametrize("exercise", EACH)
def test_without_the_reference_what_depends_on_it_waits(
    exercise: str, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing else is held to be wrong; what needs the exercise is at worst waiting for it."""
    monkeypatch.setattr(substitution, "is_possible", lambda: False)
    checks = judge(without({exercise}), cache)
    assert outcomes(checks, exercise) == {"todo"}
    for each in checks.values():
        if each.exercise != exercise and each.outcome.value != "passed":
            assert exercise in RULES.needed(RULES.checks()[each.id]), each.id
            assert each.outcome.value in ("blocked", "todo"), each.id
            if each.outcome.value == "blocked":
                assert exercise in each.waits_for, each.id
                assert exercise in each.note, each.id
                assert not each.hint, each.id
            else:
                assert not each.images, each.id  # which nobody would be shown


NEAREST = "tp2.intersect_scene.nearest"
# Both roots are looked at in the wrong order: from outside, the far side of the sphere is seen.
FAR_ROOT = {"*first = t_nearest - half_chord": "*first = t_nearest + half_chord"}


def changed(file: str, replacements: Mapping[str, str]) -> dict[str, str]:
    """Return the reference's files with words of one of them replaced."""
    files = solution()
    for old, new in replacements.items():
        assert files[file].count(old) == 1, old
        files[file] = files[file].replace(old, new)
    return files


def test_a_wrong_sphere_does_not_spoil_the_scene(cache: Path) -> None:
    """The scene's points are earned, and the note says whose mistake it is."""
    found = judge(changed("raytracer.c", FAR_ROOT), cache, 2, "sphere or intersect_scene")
    assert found["tp2.intersect_sphere.distance"].outcome.value == "failed"
    nearest = found[NEAREST]
    assert (nearest.outcome.value, nearest.points) == ("passed", nearest.max_points)
    assert nearest.note == "Points earned: your function is right, the mistake is in TP2.4."


def test_a_wrong_sphere_makes_the_scene_wait_without_the_reference(
    cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No marker is met, and yet the scene's failure may be the sphere's."""
    monkeypatch.setattr(substitution, "is_possible", lambda: False)
    found = judge(changed("raytracer.c", FAR_ROOT), cache, 2, "sphere or intersect_scene")
    assert found[NEAREST].outcome.value == "blocked"
    assert found[NEAREST].note.startswith("To be looked at after TP2.4")
    assert found["tp2.intersect_sphere.distance"].outcome.value == "failed"


def test_a_mistake_of_its_own_stays_its_own(cache: Path) -> None:
    """A scene that stops at the first hit is wrong with the right spheres too."""
    stop = {"            hit = true;\n": "            return true;\n"}
    files = changed("raytracer.c", {**stop, **FAR_ROOT})
    nearest = judge(files, cache, 2, "sphere or intersect_scene")[NEAREST]
    assert (nearest.outcome.value, nearest.points) == ("failed", 0)
    assert nearest.hint


def test_what_a_check_judges_besides_is_not_replaced(cache: Path) -> None:
    """direct_light is right by itself, and forgets in_shadow: that is TP4.1's, and not forgiven."""
    files = changed("raytracer.c", {"options.shadows && in_shadow(it, &lights[k])": "false"})
    found = judge(files, cache, keyword="direct_light or in_shadow")
    assert outcomes(found, "TP3.2") == {"passed"}
    assert found["tp4.in_shadow.used"].outcome.value == "failed"
    assert found["tp4.in_shadow.blocked"].outcome.value == "passed"


def both(one: str, other: str) -> dict[str, str]:
    """Return the reference's files with two known mistakes in them."""
    return KNOWN[other].files(KNOWN[one].files())


def test_what_is_judged_besides_is_not_replaced_for_anothers_mistake(cache: Path) -> None:
    """direct_light seems wrong until shade is mended: that is known when in_shadow asks."""
    files = both("shade_kd_ks_exchanged", "shadow_reversed")
    found = judge(files, cache, keyword="shade or direct_light or in_shadow")
    assert outcomes(found, "TP3.2") == {"passed"}
    assert found["tp4.in_shadow.used"].outcome.value == "failed"


def test_a_second_mistake_earns_no_part_of_a_picture(cache: Path) -> None:
    """Objects that hide wrongly do not make a picture without samples any better."""
    files = both("scene_first_hit", "samples_all_at_centre")
    found = judge(files, cache, keyword="intersect_scene or pixel_color or smooth_4")
    assert found[NEAREST].outcome.value == "failed"
    assert found["tp5.scene.smooth_4"].points == 0
    assert found["tp5.scene.smooth_4"].images


def test_what_trace_ray_swaps_does_not_mend_the_odds_of_glass(cache: Path) -> None:
    """Which ray was followed is told whatever is seen along it."""
    files = both("trace_answers_swapped", "glass_odds_reversed")
    found = judge(files, cache, keyword="trace_ray or glass_color")
    assert found["tp5.glass_color.odds"].outcome.value == "failed"
    alone = judge(KNOWN["trace_answers_swapped"].files(), cache, keyword="glass_color")
    assert alone["tp5.glass_color.odds"].outcome.value == "passed"


@pytest.mark.parametrize(
    ("fault", "outcome"),
    [
        (BuildError("machine.compiler_fails", command="gcc", error="killed"), "error"),
        (MixError("machine.failed", detail="the linker says no"), "blocked"),
    ],
)
def test_the_machines_fault_is_not_taken_for_the_submissions(
    fault: UserError, outcome: str, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Among the reference's functions as well; what does not go with them waits."""

    def fail(*arguments: object) -> NoReturn:
        raise fault

    monkeypatch.setattr(substitution, "substituted", fail)
    found = judge(changed("raytracer.c", FAR_ROOT), cache, 2, "sphere or intersect_scene")
    assert found[NEAREST].outcome.value == outcome


def test_functions_in_another_file_and_in_cxx_are_replaced_too(cache: Path) -> None:
    """Where a function is written, and in which of the two languages, is the student's choice."""
    files = changed("raytracer.c", FAR_ROOT)
    files["octree.c"] += "\ntemplate <int N> int only_cxx(void) { return N; }\n"
    files["more.c"] = files.pop("raytracer.c")
    files["raytracer.c"] = '#include "raytracer.h"\n'
    nearest = judge(files, cache, 2, "sphere or intersect_scene")[NEAREST]
    assert nearest.note == "Points earned: your function is right, the mistake is in TP2.4."


LOBE, MIRROR, UNIT = (f"tp5.fresnel_use.{each}" for each in ("lobe", "mirror", "unit"))


# The last two have nothing right without Fresnel, and look at all there is.
@pytest.mark.parametrize(
    "wrong",
    ["shade_h_not_unit", "mirror_black_sky", "shade_light_colour_forgotten", "mirror_twice"],
)
def test_fresnel_is_judged_in_a_function_that_is_wrong_without_it(wrong: str, cache: Path) -> None:
    """By the function's own answers without Fresnel."""
    found = judge(KNOWN[wrong].files(), cache, 5, "fresnel_use")
    assert {name: each.outcome.value for name, each in found.items()} == {
        LOBE: "passed",
        MIRROR: "passed",
        UNIT: "passed",
    }


@pytest.mark.parametrize(
    ("wrong", "use", "checks"),
    [
        ("shade_pi_forgotten", "fresnel_lobe_times_ks", {LOBE}),
        ("mirror_twice", "fresnel_mirror_direction", {MIRROR, UNIT}),
    ],
)
def test_what_is_wrong_with_fresnel_as_well_is_not_forgiven(
    wrong: str, use: str, checks: set[str], cache: Path
) -> None:
    """Two mistakes in one function."""
    found = judge(both(wrong, use), cache, 5, "fresnel_use")
    assert {name for name, each in found.items() if each.outcome.value != "passed"} == checks


SCHLICK = "options.fresnel ? fresnel_schlick({mat}kr, {n}, {v}) : {mat}ks"
JUNK_SHADE = SCHLICK.format(mat="mat->", n="n", v="v")
JUNK_MIRROR = SCHLICK.format(mat="it->mat.", n="it->normal", v="vector_float_mul(-1.f, in->dir)")
JUNK = {
    "a line": (f"return {JUNK_SHADE};", f"return {JUNK_MIRROR};"),
    "black where it may be": (
        f"if (vector_dot(n, l) <= 0.f) return vector_init(0, 0, 0); return {JUNK_SHADE};",
        f"if (in->depth >= options.max_depth) return vector_init(0, 0, 0);return {JUNK_MIRROR};",
    ),
    "a sum": (
        f"return vector_add(mat->kd, {JUNK_SHADE});",
        f"return vector_add(it->mat.kd, {JUNK_MIRROR});",
    ),
}


@pytest.mark.parametrize("junk", JUNK)
def test_the_coefficient_alone_is_no_fresnel(junk: str, cache: Path) -> None:
    """What compares a submission with itself earns only where something else is right."""
    files = solution()
    text = files["raytracer.c"]
    for name, body in zip(("shade", "mirror_color"), JUNK[junk], strict=True):
        start = text.index("{", text.index(f"color {name}(")) + 1
        text = text[:start] + body + text[text.index("\n}\n", start) :]
    found = judge({**files, "raytracer.c": text}, cache, 5, "fresnel_use")
    assert {name: (each.outcome.value, each.points) for name, each in found.items()} == {
        LOBE: ("failed", 0),
        MIRROR: ("failed", 0),
        UNIT: ("failed", 0),
    }


PROVEN = {"tp3.shade.lobe": "failed", LOBE: "passed", MIRROR: "passed"}


@pytest.mark.parametrize(
    ("outcomes", "judged"),
    [
        ({}, {"mirror_color"}),
        ({LOBE: "failed"}, {"shade", "mirror_color"}),
        ({"tp3.shade.lobe": "passed"}, {"shade", "mirror_color"}),
        ({"tp4.mirror_color.sky": "failed"}, {"shade", "mirror_color"}),
    ],
)
def test_a_proven_function_need_not_be_right_elsewhere(
    outcomes: Mapping[str, str], judged: set[str]
) -> None:
    """A picture of Fresnel's judges one function at least, and both where nothing is proven."""
    rows = {**PROVEN, **outcomes}
    found = {name: Finding(name, "", Outcome(each)) for name, each in rows.items()}
    check = RULES.checks()["tp5.scene.fresnel_0"]
    assert attribution.judged(check, found, RULES) == judged
    without = {name: each for name, each in found.items() if name not in (LOBE, MIRROR)}
    assert attribution.judged(check, without, RULES) == {"shade", "mirror_color"}


# ---- Who would have the reference's points ------------------------------------------------------

# trace_ray is wrong, so that everything above it is judged among the reference's functions.
WRONG = {"return sky_color();\n    /* END": "return vector_init(1.f, 0.f, 1.f);\n    /* END"}
PEEK = """
#include <dirent.h>
#include <dlfcn.h>
#include <string.h>
typedef color (*function)(const ray *, const intersection *);
/* The function of that name in every library that lies where ours does, but our own. */
static function other(const char *name) {
    Dl_info here;
    char folder[500], path[800];
    if (!dladdr((void *)mirror_color, &here)) return NULL;
    strcpy(folder, here.dli_fname);
    *strrchr(folder, '/') = 0;
    DIR *all = opendir(folder);
    for (struct dirent *each; all != NULL && (each = readdir(all)) != NULL;) {
        strcat(strcat(strcpy(path, folder), "/"), each->d_name);
        void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
        function found = library ? (function)dlsym(library, name) : NULL;
        if (found != NULL && found != (function)mirror_color) return found;
    }
    return NULL;
}
"""
CHEATS = {
    "asks the loader for its own name": """
#include <dlfcn.h>
typedef color (*function)(const ray *, const intersection *);
color mirror_color(const ray *in, const intersection *it) {
    function next = (function)dlsym(RTLD_NEXT, "mirror_color");
    function any = (function)dlsym(RTLD_DEFAULT, "mirror_color");
    if (next != NULL) return next(in, it);
    if (any != NULL && any != mirror_color) return any(in, it);
    return vector_init(0.f, 0.f, 0.f);
}
""",
    "looks into the libraries beside its own": PEEK
    + """
color mirror_color(const ray *in, const intersection *it) {
    function found = other("mirror_color");
    return found ? found(in, it) : vector_init(0.f, 0.f, 0.f);
}
""",
    "goes through what calls it": """
color mirror_color(const ray *in, const intersection *it) {
    static int depth;
    if (depth++) return vector_init(0.f, 0.f, 0.f);
    ray again = *in;
    color sum = hit_color(&again, it);
    depth = 0;
    return vector_minus(sum, direct_light(it, vector_float_mul(-1.f, in->dir)));
}
""",
    "is only declared": "color mirror_color(const ray *in, const intersection *it);\n",
    "is a reference that may be missing": """
extern __typeof__(mirror_color) mirror_color __attribute__((weak));
color (*kept)(const ray *, const intersection *) = mirror_color;
""",
    "is a variable": 'asm(".comm mirror_color, 64");\n',
    "is weak": """
__attribute__((weak)) color mirror_color(const ray *in, const intersection *it) {
    return vector_init(0.f, 0.f, 0.f);
}
""",
}


@pytest.mark.long
@pytest.mark.parametrize("cheat", CHEATS)
def test_the_references_points_cannot_be_had(cheat: str, cache: Path) -> None:
    """A mirror that does nothing by itself earns nothing among the reference's functions."""
    files = changed("raytracer.c", WRONG)
    text = files["raytracer.c"]
    start, end = (
        text.index("color mirror_color("),
        text.index("/* =====", text.index("color mirror_")),
    )
    files["raytracer.c"] = text[:start] + text[end:]
    files["mirror.c"] = f'#define _GNU_SOURCE\n#include "raytracer.h"\n{CHEATS[cheat]}'
    found = judge(files, cache, keyword="trace_ray or mirror_color")
    assert outcomes(found, "TP2.6") != {"passed"}
    assert earned({k: v for k, v in found.items() if k.startswith("tp4.mirror_color")}) == 0


def test_the_same_mirror_written_out_has_its_points(cache: Path) -> None:
    """What the cheats are measured against: the trial is one that can be passed."""
    found = judge(changed("raytracer.c", WRONG), cache, keyword="trace_ray or mirror_color")
    assert outcomes(found, "TP4.3") == {"passed"}
    assert "TP2.6" in found["tp4.mirror_color.sky"].note


def test_a_mixed_library_holds_nothing_of_the_reference_but_what_is_asked_for(cache: Path) -> None:
    """Neither the judged function's version, nor what nobody can call, is in it."""
    files = {name: text.encode() for name, text in without({"TP2.B2"}).items()}
    submission = Submission("rendu", files, missing=())
    needed = RULES.needed(RULES.checks()[NEAREST])
    names = {name for each in needed for name in RULES.exercise(each).functions}
    with (
        Libraries(submission, sizes_for(2), cache) as libraries,
        libraries.mixed(names) as library_set,
        Student(library_set).bench() as bench,
    ):
        library = bench.core.library.library
    listed = subprocess.run(
        ["nm", "--defined-only", library], capture_output=True, text=True, timeout=20, check=True
    )
    found = [line.split()[-1] for line in listed.stdout.splitlines()]
    assert found.count("intersect_scene") == found.count("intersect_sphere") == 1
    # The stub of the cone leaves its helper functions without a caller; the reference's go too.
    assert "solve_cone" not in found
    assert "solve_distance" in found


def test_a_function_that_is_missing_is_not_the_references(cache: Path) -> None:
    """Called all the same, it ends the process: a trap stands where the submission has nothing."""
    files = solution()
    text = files["raytracer.c"]
    start, end = (
        text.index("color mirror_color("),
        text.index("/* =====", text.index("color mirror_")),
    )
    files["raytracer.c"] = text[:start] + text[end:]
    content = {name: text.encode() for name, text in files.items()}
    with (
        Libraries(Submission("rendu", content, missing=()), sizes_for(4), cache) as libraries,
        libraries.mixed({"trace_ray"}) as library_set,
        Student(library_set).bench() as bench,
    ):
        ray, hit = bench.core.zeros("ray"), bench.core.zeros("intersection")
        with pytest.raises(Died):
            bench.session.call("mirror_color", ray, hit)


def test_only_exercises_are_global_in_the_reference(cache: Path) -> None:
    """What is replaced is known by its name: a helper that is global would not be."""
    known = {name for each in RULES.exercises for name in each.functions}
    with Builder(substitution.reference(), cache) as builder:
        symbols = builder.start(Target(96, 64)).result().symbols
    assert symbols["raytracer.c"].defined | symbols["octree.c"].defined <= known
