"""What an exception means that ends a check."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from grader.checking.expected_data import ExpectedError
from grader.checking.student import CallDied, Wrong
from grader.course.message import Message
from grader.evaluation.records import Outcome
from grader.evaluation.rules import DONE_WRONG
from grader.execution import death_messages
from grader.execution.library_set import NotBuilt
from grader.execution.records import OUT_OF_TIME, Act, Cause, Death
from grader.execution.worker_process import Died, Missing

_BESIDE = ("file", "network")  # what rightly computing code may try as well


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


def told_with_acts(
    outcome: Outcome, message: Message | None, location: str, acts: Sequence[Act]
) -> tuple[Message | None, str]:
    """Return what is told of a check, and the line, when its code tried what isolation refuses.

    Half a computation that a thread should have made is no wrong answer; a file that was not opened
    may have nothing to do with one, which is then told as well.
    """
    refused = next((each for each in acts if not each.worked), None)
    if refused is None or outcome not in DONE_WRONG:
        return message, location
    beside = refused.kind in _BESIDE and outcome is Outcome.FAILED and message is not None
    then = (replace(message, then=()), *message.then) if beside and message else ()
    calls = ((refused.function, refused.location),)
    told = Message(f"death.refused_{refused.kind}", {"calls": calls}, then)
    return told, refused.location


def remarks_on(acts: Sequence[Act]) -> tuple[Message, ...]:
    """Return what to know of acts that worked here, and would not where isolation is stronger."""
    return tuple(
        Message(f"note.worked_{each.kind}", {"function": each.function, "place": each.location})
        for each in acts
        if each.worked and each.location
    )


def was_killed(error: Exception | None) -> bool:
    """Say whether a check ended because its process was killed, by itself or from outside."""
    return isinstance(error, CallDied | Died) and error.death.cause is Cause.KILLED


def _death(death: Death, call: str, location: str) -> tuple[Outcome, Message, str]:
    outcome = Outcome.TIMEOUT if death.cause in OUT_OF_TIME else Outcome.CRASHED
    return outcome, death_messages.message(death, call), location
