"""A session in which functions are called in a given setting."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from grader.checking import describe, expected_data, reproducer
from grader.checking.comparison import Answers
from grader.checking.expected_data import Answer, Array, Batch
from grader.execution.records import Limits
from grader.execution.session import Address, Died, Library, Session

if TYPE_CHECKING:
    from grader.checking.student import Student

UNIT_LIMITS = Limits(cpu=2.0)


class Bench:
    """A session in which functions are called in a given setting."""

    def __init__(self, student: Student, session: Session, core: Library) -> None:
        self._student, self.session, self.core = student, session, core
        self._setting: Batch | None = None

    def prepare(self, batch: Batch) -> None:
        """Set the globals of a batch."""
        self._setting = batch
        expected_data.prepare(self.session, self.core, batch)

    def trial(self, batch: Batch) -> Answers:
        """Make the calls of a batch in its setting. Raises CallDied."""
        self.prepare(batch)
        answers = self.again(batch)
        self._student.todo |= self.session.todo()
        alone = partial(_alone, self.core, batch) if self._student.is_told else None
        return replace(answers, alone=alone)

    def again(self, batch: Batch, **addresses: Address) -> Answers:
        """Make the calls of a batch in the setting as it stands. Raises CallDied.

        `addresses` are arguments that all the calls share.
        """
        parameters = self.core.functions[batch.function].parameters
        only_written = ("it", "out", "r") if batch.function == "camera_ray" else ("it", "out")
        hidden = tuple(
            each.name
            for each in parameters
            if each.name in only_written and expected_data.is_written(each.ctype)
        )

        def text(case: int) -> str:
            return describe.call(batch, min(case, batch.count - 1), hidden)

        def program(case: int) -> str:
            return reproducer.of_case(batch, min(case, batch.count - 1), hidden)

        def act() -> Answer:
            return expected_data.run(self.session, self.core, batch, **addresses)

        answer = self._student.guard(batch.function, text, act, program)
        observations = self._student.observations
        return Answers(batch, answer, hidden, observations.next_batch(), observations)

    def colors(self, x: Array, y: Array) -> Array:
        """Return what the submission's own trace_ray gives through positions, shape (n, 3).

        The rays are those of its own camera_ray.
        """
        rays = self.core.zeros("ray", len(x))
        seen = self.again(Batch("camera_ray", {"r": rays, "x": x, "y": y}, {}))
        traced = self.again(Batch("trace_ray", {"r": seen.got("r")}, {}))
        return traced.got("result")

    def call(self, name: str, text: str, *args: Any) -> Any:
        """Call a function once and return its result; `text` is the call. Raises CallDied."""
        reply = self._student.guard(
            name,
            lambda case: text,
            lambda: self.session.call(name, *args),
            lambda case: reproducer.of_command(name, args, self._setting),
        )
        return reply.result


def _alone(core: Library, batch: Batch, case: int) -> Answer | None:
    """Make one call of a batch in a process of its own; None when it does not come back."""
    args = {name: column[case : case + 1] for name, column in batch.args.items()}
    one = replace(batch, args=args)
    try:
        with core.session(UNIT_LIMITS) as session:
            expected_data.prepare(session, core, one)
            return expected_data.run(session, core, one)
    except Died:
        return None


def without_answers(batch: Batch, **args: Array) -> Batch:
    """Return the batch with other arguments, and nothing expected."""
    return replace(batch, args={**batch.args, **args}, answers=())
