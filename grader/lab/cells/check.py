"""check("TP2.4"): the grader's own checks of an exercise, on the files as they are saved."""

from __future__ import annotations

from collections.abc import Sequence

from grader.course import exercises as manifest
from grader.course.exercises import ROOT, Exercise
from grader.evaluation.records import (
    CheckResult,
    ExerciseResult,
    Outcome,
    Pixel,
)
from grader.lab.cells import record
from grader.lab.cells.judge import JUDGE, Judged
from grader.lab.display import error_cards
from grader.lab.display.card import Shown, capital, card, code, escape, fold, note, stack
from grader.lab.display.links import link
from grader.lab.display.picture import tag
from grader.lab.display.stopped import Stopped
from grader.lab.display.words import say, texts
from grader.lab.inspector.jump import Checked, pointed

SYMBOLS = {
    Outcome.PASSED: "✓",
    Outcome.FAILED: "✗",
    Outcome.TODO: "○",
    Outcome.CRASHED: "✗",
    Outcome.TIMEOUT: "✗",
    Outcome.BLOCKED: "○",
    Outcome.ERROR: "?",
}
_CALM = (Outcome.TODO, Outcome.BLOCKED)
_NOTHING_TO_DO = (Outcome.PASSED, Outcome.BLOCKED)
HINTS = (2, 3)


def check(*exercises: str) -> Checked:
    """Run the grader's checks of exercises, such as "TP2.4"; return what they say.

    Or one check by its name, such as "tp4.octree.overlap". The files are judged as they are saved.
    Raises Stopped, for an exercise that does not exist too.
    """
    judged = [JUDGE.judge(*_asked(each)) for each in exercises]
    whole = stack([*(shown(each) for each in judged), *_after(judged)])
    pixels = tuple(pixel for each in judged for pixel in _pixels(each.checks)[:1])
    return Checked(whole.html, whole.text, pixels)


def _after(judged: Sequence[Judged]) -> list[Shown]:
    """Return what comes next, unless something is wrong or to do, which the cards say."""
    calm = all(each.result.outcome in _NOTHING_TO_DO for each in judged)
    if not calm or not judged[-1].is_whole:
        return []
    waits_for = [name for each in judged for check in each.checks for name in check.waits_for]
    return next_step(record.after(record.known(), judged[-1].result.id, waits_for))


def next_step(exercise: Exercise | None) -> list[Shown]:
    """Return what to work on now, and the notebook where it is told; None: all is right."""
    if exercise is None:
        return [note(say("all_right"), "good")]
    names = {"id": exercise.id, "function": exercise.functions[0], "file": exercise.file}
    told = say("next", **names)
    book = link(ROOT / "notebooks" / texts().language / f"TP{exercise.tp}.ipynb")
    return [Shown(f"<p>{escape(told)} {book.html}</p>", f"{told} {book.text}")]


def _asked(name: str) -> tuple[Exercise, str]:
    """Return an exercise, and the one check that is meant; "": all of them. Raises Stopped."""
    rules = manifest.load()
    if found := rules.checks().get(name):
        return rules.exercise(found.exercise), name
    return _exercise(name), ""


def _exercise(name: str) -> Exercise:
    rules = manifest.load()
    try:
        exercise = rules.exercise(name.upper())
    except KeyError:
        known = ", ".join(each.id for each in rules.exercises if each.checks)
        raise Stopped(error_cards.sentence("lab.no_exercise", name=name, known=known)) from None
    if not exercise.checks:
        raise Stopped(error_cards.sentence("lab.no_checks", name=exercise.id))
    return exercise


def shown(judged: Judged) -> Shown:
    """Return the card of an exercise: what is wrong in full, the rest in a line each."""
    result = judged.result
    parts = [head(result, is_whole=judged.is_whole)]
    if result.outcome is Outcome.TODO:
        calm = say("to_do", file=result.file)
        parts.append(Shown(f"<p>{escape(calm)}</p>", calm))
    else:
        parts += _checks(judged.checks)
    inside = stack(parts)
    tone = "good" if result.outcome is Outcome.PASSED else "plain"
    tone = tone if result.outcome in (Outcome.PASSED, *_CALM) else "bad"
    return card(inside.html, inside.text.replace("\n\n", "\n"), tone)


def head(result: ExerciseResult, *, is_whole: bool = True) -> Shown:
    """Return the line on an exercise, its outcome and its points; a part of one has no points."""
    line = say(
        "judged" if is_whole else "judged_part",
        symbol=SYMBOLS[result.outcome],
        id=result.id,
        function=result.function,
        title=result.title,
        outcome=word(result.outcome, result.points),
        points=_points(result),
    )
    return Shown(f"<b>{escape(line)}</b>", line)


def word(outcome: Outcome, points: float) -> str:
    """Return what became of an exercise; what waits, and has points, is right as far as it goes."""
    if outcome is Outcome.BLOCKED and points:
        return say("right_so_far")
    return texts().say(f"outcome.{outcome.value}")


def _points(result: ExerciseResult) -> str:
    number = texts().number
    return f"{number(result.points / 100)} / {number(result.max_points / 100)}"


def wrong_checks(checks: Sequence[CheckResult]) -> list[CheckResult]:
    """Return the checks that are neither right, nor to do, nor waiting."""
    return [each for each in checks if each.outcome not in (Outcome.PASSED, *_CALM)]


def _checks(checks: Sequence[CheckResult]) -> list[Shown]:
    """Tell the first check that fails in full, the others by a line; and one pixel of a picture.

    Of those that wait, the first one shows what is seen meanwhile.
    """
    parts: list[Shown] = []
    wrong = wrong_checks(checks)
    waiting = [each for each in checks if each.outcome is Outcome.BLOCKED and each.note]
    in_full = [*wrong[:1], *waiting[:1]]
    for each in checks:
        outcome = texts().say(f"outcome.{each.outcome.value}")
        line = say("checked", symbol=SYMBOLS[each.outcome], title=each.title, outcome=outcome)
        parts.append(Shown(f"<div>{escape(line)}</div>", line))
        if each.note:
            parts.append(Shown(f"<p>{escape(each.note)}</p>", f"  {each.note}"))
        if each in in_full:
            parts.append(explained(each))
    return parts + [pointed(pixel) for pixel in _pixels(checks)[:1]]


def _pixels(checks: Sequence[CheckResult]) -> list[Pixel]:
    """Return the pixels to look at, of the pictures that are wrong."""
    return [each.pixel for each in checks if each.pixel is not None]


def explained(result: CheckResult) -> Shown:
    """Return what is wrong, a question, the hints to unfold, and the pictures."""
    lines = [line for line in (result.message, result.hint, result.places) if line]
    inside = "".join(f"<p>{escape(line)}</p>" for line in lines)
    for level in HINTS:
        hint = texts().get(f"hint.{result.id}.{level}") if result.hint else ""
        inside += fold(say(f"hint.{level}"), f"<p>{escape(hint)}</p>") if hint else ""
    if result.output:
        inside += escape(texts().say("report.printed")) + code(result.output)
    if result.reproducer:
        inside += fold(say("reproducer"), code(result.reproducer))
    inside += _pictures(result)
    text = "\n".join(f"  {line}" for line in lines)
    return Shown(f'<div style="margin-left:1.2em">{inside}</div>', text)


def _pictures(result: CheckResult) -> str:
    figures = []
    for role, content in result.images.items():
        name = capital(texts().get(f"lab.role.{role}", role))
        shown = tag(content, say("picture_of", role=name, title=result.title))
        figures.append(
            f'<figure style="display:inline-block;margin:.4em .8em .4em 0">{shown.html}'
            f"<figcaption>{escape(name)}</figcaption></figure>"
        )
    return "".join(figures)
