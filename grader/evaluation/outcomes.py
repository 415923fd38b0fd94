"""What an exception means that ends a check."""

from __future__ import annotations

from grader.checking.expected_data import ExpectedError
from grader.checking.student import CallDied, Wrong
from grader.course.message import Message
from grader.evaluation.records import Outcome
from grader.execution import death_messages
from grader.execution.libraries import NotBuilt
from grader.execution.records import OUT_OF_TIME, Cause, Death
from grader.execution.worker_process import Died, Missing


def outcome_of(error: BaseException | None) -> tuple[Outcome, Message | None, str]:
    """Say what a check's exception means; whatever is not known is the grader's own fault."""
    if error is None:
        return Outcome.PASSED, None, ""
    if isinstance(error, Wrong):
        return Outcome.FAILED, error.message, ""
    if isinstance(error, CallDied):
        return _death(error.death, error.call, error.location)
    if isinstance(error, Died):  # before any call: while loading
        return _death(error.death, "", error.death.location)
    if isinstance(error, Missing):
        return Outcome.FAILED, Message("failure.missing", {"name": error.name}), ""
    if isinstance(error, NotBuilt):
        return Outcome.FAILED, error.message, ""
    if isinstance(error, ExpectedError):
        return Outcome.ERROR, Message("failure.expected", {"name": error.path.name}), ""
    detail = f"{type(error).__name__}: {error}".splitlines()[0][:300]
    return Outcome.ERROR, Message("failure.error", {"detail": detail}), ""


def was_killed(error: Exception | None) -> bool:
    """Say whether a check ended because its process was killed, by itself or from outside."""
    return isinstance(error, CallDied | Died) and error.death.cause is Cause.KILLED


def _death(death: Death, call: str, location: str) -> tuple[Outcome, Message, str]:
    outcome = Outcome.TIMEOUT if death.cause in OUT_OF_TIME else Outcome.CRASHED
    return outcome, death_messages.message(death, call), location
