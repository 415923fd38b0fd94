"""What an exception means that ends a check."""

from __future__ import annotations

from grader.checking.expected_data import ExpectedError
from grader.checking.student import Fatal, Wrong
from grader.execution import death_messages as deaths
from grader.execution.libraries import NotBuilt
from grader.execution.worker_process import Died, Missing
from grader.records import Cause, Death, Outcome, Verdict


def outcome_of(error: BaseException | None) -> tuple[Outcome, Verdict | None, str]:
    """Say what a check's exception means; whatever is not known is the grader's own fault."""
    if error is None:
        return Outcome.PASSED, None, ""
    if isinstance(error, Wrong):
        return Outcome.FAILED, error.verdict, ""
    if isinstance(error, Fatal):
        return _death(error.death, error.call)
    if isinstance(error, Died):  # before any call: while loading
        return _death(error.death, "")
    if isinstance(error, Missing):
        return Outcome.FAILED, Verdict("failure.missing", {"name": error.name}), ""
    if isinstance(error, NotBuilt):
        return Outcome.FAILED, error.verdict, ""
    if isinstance(error, ExpectedError):
        return Outcome.ERROR, Verdict("failure.expected", {"name": error.path.name}), ""
    detail = f"{type(error).__name__}: {error}".splitlines()[0][:300]
    return Outcome.ERROR, Verdict("failure.error", {"detail": detail}), ""


def was_killed(error: Exception | None) -> bool:
    """Say whether a check ended because its process was killed, by itself or from outside."""
    return isinstance(error, Fatal | Died) and error.death.cause is Cause.KILLED


def _death(death: Death, call: str) -> tuple[Outcome, Verdict, str]:
    outcome = Outcome.TIMEOUT if death.cause is Cause.TIMEOUT else Outcome.CRASHED
    return outcome, deaths.verdict(death, call), death.location
