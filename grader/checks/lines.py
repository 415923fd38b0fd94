"""The checks without code of their own: each is a line of exercises.toml, which says how to look.

A line names stored calls (`suites`) and what is compared of their answers (`compares`), or else a
function of this folder that looks at them (`helper`); or it names a picture, and perhaps `things`.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterable
from functools import partial

from grader.checking.pictures.judgement import check_picture
from grader.checking.pictures.plan import ExpectedPicture, everything
from grader.checking.student import Student
from grader.checks.common import check_answers
from grader.course.exercises import Line, ManifestError
from grader.course.nearest import nearest

Act = Callable[[Student], None]


def act_of(check: str, line: Line) -> Act:
    """Return what the check of a line does. Raises ManifestError, naming the nearest name."""
    if line.picture:
        known = {each.name: each for each in everything()}
        if line.picture not in known:
            raise _unknown(check, "picture", line.picture, known)
        return partial(_look_at_picture, picture=known[line.picture], things=line.things)
    if line.helper:
        helper = _helper(check, line.helper)
        return lambda student: helper(student, *line.suites)
    return partial(_compare, suites=line.suites, parts=line.compares)


def _look_at_picture(student: Student, picture: ExpectedPicture, things: tuple[str, ...]) -> None:
    check_picture(student, picture.scene, picture.stage, *things)


def _compare(student: Student, suites: tuple[str, ...], parts: tuple[str, ...]) -> None:
    for suite in suites:
        check_answers(student, suite, *parts)


def _helper(check: str, name: str) -> Callable[..., None]:
    """Return the function of a name such as "solids.check_meets"."""
    module_name, _, function = name.partition(".")
    try:
        module = importlib.import_module(f"grader.checks.{module_name}")
    except ImportError as error:
        problem = f"exercises.toml: {check}: there is no grader/checks/{module_name}.py"
        raise ManifestError(problem) from error
    known = [each for each in vars(module) if each.startswith("check_")]
    if function not in known:
        raise _unknown(check, "helper", name, [f"{module_name}.{each}" for each in known])
    found: Callable[..., None] = getattr(module, function)
    return found


def _unknown(check: str, what: str, name: str, known: Iterable[str]) -> ManifestError:
    near = nearest(name, known)
    return ManifestError(
        f"exercises.toml: {check}: there is no {what} {name}; the nearest is {near}"
    )
