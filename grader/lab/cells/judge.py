"""What the checks of a notebook's exercises say, on the files as they are saved."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

from grader.build.records import BindError
from grader.checking.shapes import Size
from grader.course import exercises as manifest
from grader.course.exercises import Exercise, Manifest
from grader.course.message import UserError
from grader.course.sizes import sizes_for
from grader.evaluation.grading import grade
from grader.evaluation.records import CheckResult, ExerciseResult, Finding, Outcome, PytestError
from grader.evaluation.rules import DONE_WRONG
from grader.execution.libraries import Libraries
from grader.execution.worker_process import MachineError
from grader.files import marks
from grader.intake.submission import read_submission
from grader.lab.bridge.idle import Idle
from grader.lab.bridge.saves import SAVES
from grader.lab.cells import album, record
from grader.lab.display import error_cards
from grader.lab.display.links import core_folder, outputs
from grader.lab.display.stopped import Stopped
from grader.lab.display.words import texts

_JUDGING = threading.Lock()  # pytest runs once at a time in a process


@dataclass(frozen=True)
class Judged:
    """An exercise and its checks, in the language of the notebook."""

    result: ExerciseResult
    checks: tuple[CheckResult, ...]
    is_whole: bool = True  # whether all the checks were run


class Judge:
    """What the checks of this notebook share: the builds of the files as they were last saved."""

    def __init__(self) -> None:
        self.done: dict[str, Judged] = {}  # by exercise, of this session
        self._key: object = None
        self._libraries: Libraries | None = None
        self._stack = ExitStack()
        self._idle = Idle(self.close)

    def judge(self, exercise: Exercise, only: str = "") -> Judged:
        """Run the checks of an exercise, or one of them; when no other thread does.

        Raises Stopped.
        """
        self._idle.used()
        with _JUDGING:
            return self._judge(exercise, only)

    def _judge(self, exercise: Exercise, only: str) -> Judged:
        from grader.evaluation.pipeline import run_checks

        try:
            libraries = self._open(core_folder(), sizes_for(exercise.tp))
            rules = manifest.load()
            chosen = [only] if only else [each.id for each in exercise.checks]
            findings = run_checks(libraries, rules, exercise.tp, chosen)
            for tp, names in [] if only else _earlier(findings, rules, exercise):
                findings += run_checks(libraries, rules, tp, names)
        except UserError as error:
            raise Stopped(error_cards.sentence(error.key, **error.values)) from None
        except (BindError, MachineError, PytestError) as error:
            self.close()
            raise Stopped(error_cards.sentence("machine.failed", detail=error)) from None
        checks, results = grade(findings, rules, texts(), rejected=libraries.rejected)
        if spoilt := self._wrong_before(exercise, results):
            self._judge(rules.exercise(spoilt), "")
        result = next(each for each in results if each.id == exercise.id)
        own = tuple(each for each in checks if each.exercise == exercise.id)
        self.done[exercise.id] = judged = Judged(result, own, not only)
        if not only:
            record.keep(result)
            if result.outcome is Outcome.PASSED:
                album.keep(exercise, libraries)
        return judged

    def _wrong_before(self, exercise: Exercise, results: Sequence[ExerciseResult]) -> str:
        """Return the first exercise that is wrong and spoils this one; "" when none is."""
        others = (each for each in results if each.id != exercise.id)
        return next((each.id for each in others if each.outcome in DONE_WRONG), "")

    def close(self) -> None:
        """Forget the builds, and end their workers."""
        self._stack.close()
        self._libraries = self._key = None

    def _open(self, folder: Path, sizes: Sequence[Size]) -> Libraries:
        key = (folder, marks(folder), tuple(sizes))
        if self._libraries is None or key != self._key:
            self.close()
            submission = read_submission(folder)
            SAVES.note(folder, submission.files)
            libraries = Libraries(submission, sizes, outputs() / "cache")
            self._libraries, self._key = self._stack.enter_context(libraries), key
        return self._libraries


def _earlier(
    findings: Sequence[Finding], rules: Manifest, exercise: Exercise
) -> list[tuple[int, list[str]]]:
    """Return the checks of functions, by TP, that what fails may wait for: see settle.

    So that what an earlier exercise has spoilt waits here too, as it does in a whole grade.
    """
    wrong = [rules.checks()[each.check] for each in findings if each.outcome in DONE_WRONG]
    names = {name for each in wrong for name in rules.waited_for(each)} - {exercise.id}
    asked = [each for each in rules.exercises if each.id in names]
    return [
        (tp, [check.id for each in own for check in each.checks if not check.is_picture])
        for tp, group in groupby(asked, key=lambda each: each.tp)
        if (own := list(group)) and sizes_for(tp) == sizes_for(exercise.tp)
    ]


JUDGE = Judge()
