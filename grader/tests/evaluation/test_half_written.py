"""Half-written programs, in a student's copy: what is wrong is shown, and never hidden."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

from grader.authoring.specimens import mistakes, patches
from grader.authoring.specimens.half_written import just_reached
from grader.course import exercises
from grader.course.sizes import sizes_for
from grader.course.texts import Texts
from grader.evaluation.pipeline import report_of, run_checks
from grader.evaluation.records import Outcome, Report
from grader.execution.libraries import Libraries
from grader.lab.cells.check import shown
from grader.lab.cells.judge import Judged
from grader.report import page
from grader.report.results import as_json
from grader.report.text import View
from grader.tests.support.sampling import sampled

RULES = exercises.load()
TEXTS = Texts("fr")
RED = (Outcome.FAILED, Outcome.CRASHED, Outcome.TIMEOUT, Outcome.ERROR)

PIXEL = "output_image[j * WIDTH + i] = trace_ray(&r);"
RAY = "(float)i + 0.5f, (float)j + 0.5f"
TOWARDS = "vector_normalized(vector_minus(lights[k].position, it->position))"
ADDED = "        sum = vector_add(sum, shade("
MIRRORED = "return vector_vec_mul(k, trace_ray(&reflected));"
AFTER_CYLINDER = "\n    /* END SOLUTION */\n}\n\n/* BEGIN SOLUTION TP2.B2"
# By name: the exercise, what stands in the solution, and what a student wrote in its place.
SLIPS: Mapping[str, tuple[str, str, str]] = {
    "rows for columns": ("TP2.2", PIXEL, "output_image[i * WIDTH + j] = trace_ray(&r);"),
    "upside down": ("TP2.2", PIXEL, PIXEL.replace("[j *", "[(HEIGHT - 1 - j) *")),
    "half a pixel": ("TP2.2", RAY, "(float)i, (float)j"),
    "no first value": ("TP2.5", "bool hit = false;\n    for", "bool hit;\n    for"),
    "no first colour": (
        "TP3.2",
        "color sum = vector_init(0.f, 0.f, 0.f);\n    /* END",
        "color sum;\n    /* END",
    ),
    "endless": ("TP2.2", "j < HEIGHT; j++", "j < HEIGHT; j = j + 0"),
    "without a value": ("TP2.2", PIXEL, "color c;\noutput_image[j * WIDTH + i] = c;"),
    "crash": ("TP2.2", PIXEL, "*(volatile int *)8 = i;"),
    "depth": ("TP2.6", "r->depth > options.max_depth", "false"),
    "from the light": ("TP3.2", TOWARDS, f"vector_float_mul(-1.f, {TOWARDS})"),
    "not unit": ("TP3.2", TOWARDS, TOWARDS.removeprefix("vector_normalized")),
    "sum dropped": ("TP3.2", ADDED, ADDED.replace("sum = ", "(void)")),
    "no return": ("TP4.3", MIRRORED, "trace_ray(&reflected);"),
    "a miss that writes": (
        "TP2.B1",
        f"    return hit;{AFTER_CYLINDER}",
        f"    if (!hit) {{\n        it->mat = obj->mat;\n    }}\n    return hit;{AFTER_CYLINDER}",
    ),
    "a constant": ("TP4.3", "color k = it->mat.ks;", "color k = vector_init(.5f, .5f, .5f);"),
}

# One of each kind, for `make test`.
SHOWN = (
    *("rows for columns", "no first value", "endless", "crash", "sum dropped", "no return"),
    "a miss that writes",
)


def judged(exercise: str, files: Mapping[str, str], cache: Path) -> Report:
    """Judge a program on the checks of the exercise's TP, as in a student's copy."""
    tp = RULES.exercise(exercise).tp
    submission = patches.submission("rendu", files)
    with Libraries(submission, sizes_for(tp), cache) as libraries:
        findings = run_checks(libraries, RULES, tp, with_reference=False)
        return report_of(libraries, RULES, findings, TEXTS)


def red(report: Report) -> set[str]:
    """Return the exercises of which something is said to be wrong."""
    return {each.exercise for each in report.checks if each.outcome in RED}


def assert_told(exercise: str, report: Report) -> None:
    """Assert that the mistake is shown at its exercise alone, wherever a student looks."""
    assert red(report) == {exercise}
    first = next(each for each in report.checks if each.outcome in RED)
    content = {**as_json(report, TEXTS), "isolation": "strong"}
    view = View(content, Path("report.html"), TEXTS, 0)
    assert any(first.message.splitlines()[0] in line for line, _ in view.lines())
    assert any(exercise in line for line, _ in view.summary.next_step())
    opened = page.render(content, Path("nowhere")).split(f'id="{exercise}" open>')
    assert len(opened) == 2, "the page opens the exercise"
    result = next(each for each in report.exercises if each.id == exercise)
    own = tuple(each for each in report.checks if each.exercise == exercise)
    assert first.message in shown(Judged(result, own)).text


@pytest.mark.parametrize("slip", sampled(SLIPS, SHOWN, SHOWN[::3]))
def test_a_slip_is_shown_though_all_that_follows_is_a_stub(slip: str, cache: Path) -> None:
    """Who has just written a function sees what is wrong in it, there and nowhere else."""
    exercise, right, wrong = SLIPS[slip]
    files = patches.reference()
    assert files["raytracer.c"].count(right) == 1
    files["raytracer.c"] = files["raytracer.c"].replace(right, wrong)
    assert_told(exercise, judged(exercise, just_reached(exercise, files), cache))


@pytest.mark.parametrize("bonuses", [True, False])
@pytest.mark.parametrize("exercise", ["TP2.2", "TP2.B2", "TP4.1"])
def test_what_is_right_so_far_shows_nothing_red(exercise: str, bonuses: bool, cache: Path) -> None:
    """What waits is calm; the function just written has every point that can be judged."""
    report = judged(exercise, just_reached(exercise, bonuses=bonuses), cache)
    assert red(report) == set()
    own = [each for each in report.checks if each.exercise == exercise]
    assert {each.outcome for each in own} <= {Outcome.PASSED, Outcome.BLOCKED}
    assert all(each.outcome is Outcome.PASSED for each in own if ".scene." not in each.id)


def test_a_colour_without_light_is_right_before_there_is_light(cache: Path) -> None:
    """Where trace_ray returns kd, the pictures of direct_light, a stub, are still to be done."""
    files = patches.reference()
    assert files["raytracer.c"].count("return hit_color(r, &it);") == 1
    files["raytracer.c"] = files["raytracer.c"].replace("hit_color(r, &it);", "it.mat.kd;")
    submission = patches.submission("rendu", just_reached("TP2.6", files, bonuses=False))
    with Libraries(submission, sizes_for(3), cache) as libraries:
        findings = run_checks(libraries, RULES, 3, with_reference=False)
        report = report_of(libraries, RULES, findings, TEXTS)
    assert red(report) == set()
    of_light = {each.outcome for each in report.checks if each.exercise == "TP3.2"}
    assert of_light == {Outcome.TODO}


def test_a_wrong_light_does_not_ask_for_the_bonuses(cache: Path) -> None:
    """A right checkerboard in the wrong light of direct_light waits for that, not for the image."""
    wrong = next(each for each in mistakes.load() if each.id == "light_direction_reversed")
    report = judged("TP3.B1", just_reached("TP3.B1", wrong.files()), cache)
    assert red(report) == {"TP3.2"}
    (waiting,) = (each for each in report.checks if each.id == "tp3.scene.checker_6")
    assert waiting.waits_for == ("TP3.2",)
    assert waiting.message
    assert waiting.images["got"]
    assert waiting.hint == ""


def test_raytrace_counts_with_the_sky_alone(cache: Path) -> None:
    """Before trace_ray is written, what raytrace does with its rays is judged, and counts."""
    report = judged("TP2.2", just_reached("TP2.2"), cache)
    own = {each.id: each for each in report.checks if each.exercise == "TP2.2"}
    assert [each.id for each in own.values() if each.points] == [
        "tp2.raytrace.colors",
        "tp2.raytrace.centre",
        "tp2.raytrace.every_pixel",
    ]
    assert own["tp2.scene.flat_0"].waits_for == ("TP2.6",)
