"""A mistake is shown in a half-written program too, in a student's copy, without the reference.

Each exercise is taken as it stands for who has just reached it: everything before it is right,
everything after it is a stub; and once more with every bonus before it left out. Alone it must be
free of red; with each of its known mistakes in it the mistake must be shown at its own exercise,
on the terminal and on the page, nothing else may be red, and the next step must be that exercise.
"""

from __future__ import annotations

import html
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from grader.authoring.proof.grades import Grade, GradeCache, Program
from grader.authoring.proof.parts import Part, listed, sampled
from grader.authoring.specimens import mistakes
from grader.authoring.specimens.half_written import just_reached
from grader.authoring.specimens.mistakes import Mistake
from grader.course import exercises
from grader.course.texts import Texts
from grader.report import page
from grader.report.text import View

RED = ("failed", "crashed", "timeout", "error")
_WAYS = {"with its bonuses": True, "without bonuses": False}


@dataclass(frozen=True)
class Reached:
    """A program of who has just reached an exercise; `mistake` is None when it is right so far.

    The mistake is one of this exercise, or of an earlier one that nothing could show before.
    """

    exercise: str
    mistake: Mistake | None
    bonuses: bool

    @property
    def program(self) -> Program:
        """As it is graded: in a student's copy, on the checks of its TP and those before."""
        files = just_reached(
            self.exercise, self.mistake.files() if self.mistake else None, bonuses=self.bonuses
        )
        return Program(self.name, files, with_reference=False)

    @property
    def name(self) -> str:
        """What it is called in the proof."""
        what = self.mistake.id if self.mistake else self.exercise
        return what if self.bonuses else f"{what} without bonuses"


def run(grade_cache: GradeCache, sample: int | None = None) -> Part:
    """Grade the programs, or some of them. Raises ProofError."""
    chosen = sampled(list(programs()), sample)
    grades = {each.id: grade for each, grade in grade_cache.graded(p.program for p in chosen)}
    return report([(each, grades[each.name]) for each in chosen], sample is None)


def programs() -> Iterator[Reached]:
    """Yield every program: each exercise that is judged, right, then with each of its mistakes."""
    for bonuses in _WAYS.values():
        for exercise in exercises.load().exercises:
            if exercise.checks:
                yield Reached(exercise.id, None, bonuses)
        for mistake in mistakes.load():
            yield Reached(mistake.seen_from, mistake, bonuses)


def report(found: Iterable[tuple[Reached, Grade]], whole: bool = True) -> Part:
    """Return the part of the proof from the grades."""
    told = {program.name: (program, list(faults(program, grade))) for program, grade in found}
    wrong = [lines for program, lines in told.values() if program.mistake]
    right = [lines for program, lines in told.values() if not program.mistake]
    return Part(
        "half_written",
        "Half-written programs, in a student's copy",
        {
            "half_written": len(wrong),
            "half_written_shown": sum(not lines for lines in wrong),
            "half_right": len(right),
            "half_right_calm": sum(not lines for lines in right),
        },
        [line for _, lines in told.values() for line in lines],
        ["program", "exercise", "what is not as it should be"],
        [[name, each.exercise, "; ".join(lines)] for name, (each, lines) in told.items()],
        whole,
    )


def faults(program: Reached, grade: Grade) -> Iterator[str]:
    """Yield what is not as it should be, a line each."""
    checks = grade.content["checks"]
    exercise = program.mistake.exercise if program.mistake else program.exercise
    red = {each["exercise"] for each in checks if each["outcome"] in RED}
    if elsewhere := red - {exercise}:
        yield f"{program.name}: {listed(elsewhere)} is red too"
    if program.mistake is None:
        if exercise in red:
            yield f"{program.name}: is red, and right"
        return
    own = [each for each in checks if each["exercise"] == exercise]
    shown = [each for each in own if each["outcome"] in RED]
    if not shown:
        yield f"{program.name}: is not shown in {exercise}"
        return
    # What a grade that is kept leaves out.
    content = {**grade.content, "isolation": "strong", "graded_at": "2026-01-01T00:00:00+00:00"}
    view = View(content, Path("report.html"), Texts(content["language"]), 0)
    lines = [line for line, _ in view.lines()]
    if not any(shown[0]["message"].splitlines()[0] in line for line in lines):
        yield f"{program.name}: is not told on the terminal"
    if not any(exercise in line for line, _ in view.summary.next_step()):
        yield f"{program.name}: {exercise} is not the next step"
    if shown[0]["title"] not in html.unescape(page.render(content, Path("nowhere"))):
        yield f"{program.name}: is not on the page"
