"""What a person is told, by its key in messages/; and the errors that end a command with it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from grader.course.texts import Texts


class GraderError(Exception):
    """A file of the course is wrong: who maintains it is told in English."""

    code = 3  # with which a command ends: see console/run.py

    def sentence(self, texts: Texts) -> str:
        """Return what to tell the person at the terminal."""
        return str(self)


class FaultError(GraderError):
    """The grader's or the machine's fault: never the submission's."""

    def sentence(self, texts: Texts) -> str:
        """Return that the machine has failed, with the error's own words."""
        return texts.say("machine.failed", detail=self)


class UserError(GraderError):
    """An error with a sentence of its own in messages/, by its key."""

    def __init__(self, key: str, **values: object) -> None:
        super().__init__(f"{key}: {values}")
        self.key = key
        self.values = values

    def sentence(self, texts: Texts) -> str:
        """Return its sentence."""
        return texts.say(self.key, **self.values)


@dataclass(frozen=True)
class Message:
    """What is wrong: the sentence of `key` in messages/, with its values, and what is added."""

    key: str
    values: dict[str, object] = field(default_factory=dict)
    then: tuple[Message, ...] = ()
