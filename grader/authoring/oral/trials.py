"""Running a submission, as it is and with a line changed: its checks, and its pictures.

The code runs in the worker alone, at the best level of isolation that the machine gives.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from grader.authoring.oral.records import Change, Drawn, Sight, Swapped
from grader.authoring.specimens.mistakes import Mistake
from grader.checking import c_literals
from grader.checking.expected_data import FOLDER
from grader.checking.pictures import expected_files
from grader.checking.pictures.measure import LEVEL
from grader.checking.pictures.plan import SAMPLES, ExpectedPicture
from grader.checking.reproducer import command_of
from grader.checking.shapes import Image
from grader.checking.student import CallDied, Student
from grader.course import exercises, scenes
from grader.course.message import Message
from grader.course.sizes import PICTURE, sizes_for
from grader.course.texts import Texts
from grader.evaluation import recognition
from grader.evaluation.grading import grade
from grader.evaluation.pipeline import run_checks
from grader.evaluation.records import CheckResult, Outcome
from grader.execution import death_messages
from grader.execution.libraries import Libraries
from grader.execution.library_set import NotBuilt
from grader.execution.worker_process import Died, Missing
from grader.intake.records import Submission

ENOUGH = 0.005  # share of the pixels that tells a picture from another at a glance
SEEN = 3 * LEVEL  # by which a pixel must change to be seen
# The stages of the ray tracer, with the exercises that each needs besides those before it.
_STAGES: Mapping[str, tuple[str, ...]] = {
    "flat": ("TP2.1", "TP2.2", "TP2.3", "TP2.4", "TP2.5", "TP2.6"),
    "blinn_phong": ("TP3.1", "TP3.2"),
    "shadows": ("TP4.1",),
    "mirror": ("TP4.2", "TP4.3"),
    "fresnel": ("TP5.1", "TP5.2"),
}
# The scenes in which what is no bonus may be seen, the best one first. The spheres of TP5.B2 are
# too many to be drawn without the octree: no scene shows them.
_USUAL = (4, 0, 1)
_TEAL, _YELLOW = (0.2, 0.6, 0.7), (1.0, 0.9, 0.2)
# What is drawn with TP1's functions.
_CALLS: Mapping[str, tuple[dict[str, Any], ...]] = {
    "fill_red": ({},),
    "fill": ({"c": _TEAL},),
    "horizontal_gradient": ({"c1": (0, 0, 1), "c2": (1, 1, 1)},),
    "fill_rect": (
        {"c": _TEAL, "p1": (60, 30, 0), "p2": (220, 130, 0)},
        {"c": _TEAL, "p1": (220, 130, 0), "p2": (60, 30, 0)},
        {"c": _TEAL, "p1": (250, 110, 0), "p2": (390, 240, 0)},
    ),
    "fill_circle": (
        {"radius": 50, "center": (160, 90, 0), "c": _YELLOW},
        {"radius": 60, "center": (290, 150, 0), "c": _YELLOW},
        {"radius": 3, "center": (20, 20, 0), "c": _YELLOW},
    ),
}


@dataclass(frozen=True)
class TrialView:
    """One picture that may be drawn: a call of TP1's, or a scene with options."""

    call: str
    scene: int | None
    settings: Mapping[str, Any]  # the call's arguments, or fields of `options`


class TrialProgram:
    """A submission that is built: what its checks give, and what it draws."""

    def __init__(self, libraries: Libraries, texts: Texts) -> None:
        self._libraries, self._texts = libraries, texts
        self._drawn: dict[str, Drawn] = {}

    def checks(self, tp: int | None = None, exercise: str = "") -> dict[str, CheckResult]:
        """Run the checks of an exercise, of a TP, or of all that count; return them by id."""
        rules = exercises.load()
        chosen = None
        if exercise:
            asked = rules.exercise(exercise)
            tp, chosen = asked.tp, [each.id for each in asked.checks]
        findings = run_checks(self._libraries, rules, tp, chosen)
        rejected = self._libraries.rejected
        checks, _ = grade(findings, rules, self._texts, rejected=rejected)
        return {each.id: each for each in checks if exercise in ("", each.exercise)}

    def draw(self, view: TrialView) -> Drawn:
        """Draw a picture, once."""
        if view.call not in self._drawn:
            self._drawn[view.call] = self._draw(view)
        return self._drawn[view.call]

    def _draw(self, view: TrialView) -> Drawn:
        file = "main.c" if view.scene is None else "raytracer.c"
        try:
            student = Student(self._libraries.lend(file))
            if view.scene is None:
                with student.canvas(PICTURE) as canvas:
                    black = np.zeros((PICTURE[1], PICTURE[0], 3), np.float32)
                    name = view.call.partition("(")[0]
                    return Drawn(_shown(canvas.draw(name, black, **view.settings).after))
            patterned = scenes.load()[view.scene].patterned
            texels = expected_files.read_texels(FOLDER) if patterned else None
            return Drawn(_shown(student.picture(view.scene, texels, **view.settings)))
        except CallDied as error:
            what, place = death_messages.message(error.death, error.call), error.death.location
        except Died as error:
            what, place = death_messages.message(error.death, ""), error.death.location
        except Missing as error:
            what, place = Message("failure.missing", {"name": error.name}), ""
        except NotBuilt as error:
            what, place = error.message, ""
        return Drawn(death=death_messages.told(what, place, self._texts))


class Laboratory:
    """A submission, and what becomes of it when a line is changed; a context manager."""

    def __init__(self, submission: Submission, cache: Path, texts: Texts) -> None:
        self.submission = submission
        self._cache, self._texts = cache, texts
        self._libraries = Libraries(submission, sizes_for(None), cache)
        self.program = TrialProgram(self._libraries, texts)

    def __enter__(self) -> Laboratory:
        return self

    def __exit__(self, *problem: object) -> None:
        self._libraries.close()

    @property
    def libraries(self) -> Libraries:
        """The submission as it is."""
        return self._libraries

    def tried(
        self, change: Change, base: Mapping[str, CheckResult], begun: Collection[str]
    ) -> Swapped | None:
        """Put a change in; return its question, or None when it is not that mistake at all.

        `base` are the results without it, and `begun` the exercises that are written. It is that
        mistake when it builds, when a check that passed and ought to see it fails, and when its
        answers are recognised: the same change may do something else in another hand.
        """
        mistake = change.mistake
        content = change.content.encode("utf-8", "surrogateescape")
        files = {**self.submission.files, change.place.file: content}
        changed = replace(self.submission, files=files)
        with Libraries(changed, sizes_for(mistake.tp), self._cache) as libraries:
            if set(libraries.rejected) - set(self._libraries.rejected):
                return None
            program = TrialProgram(libraries, self._texts)
            results = program.checks(exercise=mistake.exercise)
            if any(each.outcome is Outcome.ERROR for each in results.values()):
                return None
            lost = {name: base[name].points - each.points for name, each in results.items()}
            failed = [results[name] for name, points in lost.items() if points > 0]
            if not {each.id for each in failed} & set(mistake.shows):
                return None
            if not _is_recognised(mistake, failed):
                return None
            sight = self._sight(mistake.exercise, program, begun)
        total = exercises.load().exercise(mistake.exercise).points
        return Swapped(change, tuple(failed), sum(lost.values()), total, sight)

    def _sight(self, exercise: str, program: TrialProgram, begun: Collection[str]) -> Sight | None:
        """Return the picture in which the change shows best; None when there is none to draw."""
        best: Sight | None = None
        for view in views(exercise, begun):
            before = self.program.draw(view).picture
            if before is None:
                continue
            after = program.draw(view)
            share = 1.0 if after.picture is None else _changed(before, after.picture)
            if best is None or share > best.changed:
                best = Sight(view.call, view.scene, before, after, share)
            if share >= ENOUGH:
                break
        return best


def _is_recognised(mistake: Mistake, failed: Sequence[CheckResult]) -> bool:
    """Say whether checks give the answers of a mistake; those of which none are stored, any."""
    named = {name for each in failed for name in each.mistakes}
    if named:
        return bool(named & {mistake.id, *mistake.twins})
    return mistake.id not in recognition.read(FOLDER)


def views(exercise: str, begun: Collection[str]) -> Iterator[TrialView]:
    """Yield the pictures in which an exercise may be seen, by what else is written."""
    asked = exercises.load().exercise(exercise)
    if asked.tp == 1:
        for settings in _CALLS.get(asked.functions[0], ()):
            words = [f"{key} = {literal(value)}" for key, value in settings.items()]
            yield TrialView(f"{asked.functions[0]}({', '.join(['img', *words])})", None, settings)
        return
    stage = _stage(exercise, begun)
    own = [number for number, each in scenes.load().items() if exercise in each.shows]
    for scene in (own if asked.bonus else _USUAL) if stage else ():
        options = ExpectedPicture(scene, "glass" if exercise == "TP5.B1" else stage).options
        if exercise == "TP5.3":
            options["samples"] = SAMPLES
        # The scenes but that of glass are opaque, and what is not written makes no difference.
        left = {"refraction", *(() if "TP4.B1" in begun else ("octree",))}
        told = {key: value for key, value in options.items() if key not in left}
        words = [word for _, word in c_literals.settings(told)]
        command = " ".join([command_of(scene), *words])
        yield TrialView(command, scene, options)


def literal(value: Any) -> str:
    """Return a number, or a triple of them, as it is told."""
    if isinstance(value, Sequence):
        return f"({', '.join(map(literal, value))})"
    return f"{value:g}"


def _stage(exercise: str, begun: Collection[str]) -> str:
    """Return the last stage of which everything is written; "" when it lacks the exercise."""
    last = ""
    seen: set[str] = set()
    for name, needed in _STAGES.items():
        if not set(needed) <= set(begun):
            break
        last, seen = name, seen | set(needed)
    core = {each for needed in _STAGES.values() for each in needed}
    return last if exercise in seen or exercise not in core else ""


def _shown(picture: Image) -> Image:
    """Return a picture as it is seen: finite, from 0 to 1."""
    return np.clip(np.nan_to_num(picture, nan=0.0, posinf=1.0, neginf=0.0), 0, 1)


def _changed(before: Image, after: Image) -> float:
    return float((np.abs(after - before).max(axis=2) > SEEN).mean())


def is_begun(checks: Sequence[CheckResult]) -> bool:
    """Say whether an exercise is written, and came back from its calls."""
    bad = (Outcome.TODO, Outcome.ERROR, Outcome.CRASHED, Outcome.TIMEOUT)
    return not any(each.outcome in bad or each.waits_for for each in checks)
