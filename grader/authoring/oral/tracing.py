"""Questions on values: what the student's own function gives for one simple call."""

from __future__ import annotations

import random
from collections.abc import Mapping

import numpy as np

from grader.authoring.oral.records import Place, Traced, Value
from grader.authoring.oral.tokens import functions
from grader.authoring.oral.trials import literal
from grader.checking import describe
from grader.checking.comparison import Answers, far
from grader.checking.student import CallDied, Student
from grader.course import exercises
from grader.course.sizes import UNIT
from grader.execution.libraries import Libraries
from grader.execution.library_set import NotBuilt
from grader.execution.worker_process import Died, Missing
from grader.intake.records import Submission

SIMPLEST = 3  # calls of a suite from which one is drawn
_HIT = ("result", "r.tmax", "it.position", "it.normal")
# Suites of calls that can be followed on paper, and what is asked of them.
_SUITES: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "TP2.3": {"intersect_plane.front": _HIT, "intersect_plane.behind": ("result",)},
    "TP2.4": {
        "intersect_sphere.front": _HIT,
        "intersect_sphere.inside": _HIT,
        "intersect_sphere.behind": ("result",),
    },
    "TP2.5": {"intersect_scene.nearest": ("result", "r.tmax", "it.normal")},
    "TP2.6": {"trace_ray.sky": ("result",)},
    "TP2.B1": {"intersect_cylinder.front": _HIT},
    "TP2.B2": {"intersect_cone.front": _HIT},
    "TP3.1": {"shade.diffuse": ("result",), "shade.back": ("result",)},
    "TP3.2": {"direct_light.none": ("result",), "direct_light.one": ("result",)},
    "TP3.B1": {"checker_color.negative": ("result",), "checker_color.positive": ("result",)},
    "TP4.1": {"in_shadow.beyond": ("result",), "in_shadow.blocked": ("result",)},
    "TP4.2": {"reflected_ray.unit": ("out.dir", "out.tmax", "out.depth")},
    "TP4.3": {"mirror_color.sky": ("result",)},
    "TP5.1": {"reflectance.any": ("result",), "fresnel_schlick.grazing": ("result",)},
    "TP5.B1": {"refracted_ray.entering": ("result", "out.dir")},
}
# Of TP1: the pixels that a call changes, and how many they are (both readings of a rectangle).
_DRAWN: Mapping[str, tuple[dict[str, object], tuple[int, ...]]] = {
    "fill": ({"c": (1, 1, 1)}, (UNIT[0] * UNIT[1],)),
    "fill_rect": ({"c": (1, 1, 1), "p1": (2, 1, 0), "p2": (5, 3, 0)}, (12, 6)),
    "fill_circle": ({"radius": 2, "center": (10, 10, 0), "c": (1, 1, 1)}, (9,)),
}
PIXELS = "pixels"  # the name of their number


def traced(
    exercise: str, submission: Submission, libraries: Libraries, rng: random.Random
) -> Traced | None:
    """Return a question on what a call gives; None when there is none, or it does not come back."""
    asked = exercises.load().exercise(exercise)
    student = Student(libraries.lend(asked.file))
    try:
        if asked.tp == 1:
            return _drawing(asked.functions[0], exercise, submission, student)
        suites = _SUITES.get(exercise)
        if not suites:
            return None
        suite = rng.choice(sorted(suites))
        trial = student.trials(suite)[0]
        return _call(trial, suites[suite], exercise, submission, rng)
    except (CallDied, Died, Missing, NotBuilt):
        return None


def _call(
    trial: Answers,
    picks: tuple[str, ...],
    exercise: str,
    submission: Submission,
    rng: random.Random,
) -> Traced | None:
    count = trial.batch.count
    simple = sorted(range(count), key=lambda k: (describe.complexity(trial.batch, k), k))
    case = rng.choice(simple[:SIMPLEST])
    right = Answers(trial.batch, trial.batch.answers[0])
    values = []
    for pick in picks:
        got, expected = trial.got(pick)[case], right.got(pick)[case]
        wrong = far(np.array([got]), np.array([expected]), trial.batch.tolerance)[0]
        values.append(Value(pick, describe.value(got), describe.value(expected) if wrong else ""))
        if pick == "result" and expected.dtype == bool and not expected:
            break  # a miss writes nothing
    place = where(submission, trial.batch.function)
    return Traced(exercise, place, trial.call(case), tuple(values)) if place else None


def _drawing(name: str, exercise: str, submission: Submission, student: Student) -> Traced | None:
    if name not in _DRAWN:
        return None
    args, accepted = _DRAWN[name]
    with student.canvas(UNIT) as canvas:
        black = np.zeros((UNIT[1], UNIT[0], 3), np.float32)
        count = int((canvas.draw(name, black, **args).after != 0).any(axis=2).sum())
    right = "" if count in accepted else str(accepted[0])
    words = ", ".join(f"{key} = {literal(value)}" for key, value in args.items())
    call = f"{name}(img, {words}) [WIDTH {UNIT[0]}, HEIGHT {UNIT[1]}]"
    place = where(submission, name)
    value = Value(PIXELS, str(count), right)
    return Traced(exercise, place, call, (value,)) if place else None


def where(submission: Submission, function: str) -> Place | None:
    """Return where a submission defines a function, with its text."""
    for file, content in submission.files.items():
        text = content.decode("utf-8", "surrogateescape")
        found = functions(text).get(function) if file.endswith(".c") else None
        if found:
            begin, end = text.rfind("\n", 0, found.start) + 1, found.body[-1].end
            return Place(file, text.count("\n", 0, begin) + 1, function, text[begin:end])
    return None
