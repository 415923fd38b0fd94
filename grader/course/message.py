"""What a person is told, by its key in messages/; and the errors that end a command with it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

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
    """What is wrong: the sentence of `key` in messages/, with its values, and what is added.

    A value may be a message too, or several of them, one right behind the other.
    """

    key: str
    values: dict[str, object] = field(default_factory=dict)
    then: tuple[Message, ...] = ()

    def as_row(self) -> dict[str, Any]:
        """Return it as JSON has it: a number stays one, anything else is as a sentence has it."""
        row: dict[str, Any] = {"key": self.key}
        if self.values:
            row["values"] = {name: _as_json(each) for name, each in self.values.items()}
        if self.then:
            row["then"] = [each.as_row() for each in self.then]
        return row

    @staticmethod
    def of_row(row: Mapping[str, Any]) -> Message:
        """Return the message of such a row."""
        values = {name: _of_json(each) for name, each in row.get("values", {}).items()}
        return Message(row["key"], values, tuple(map(Message.of_row, row.get("then", ()))))


def _as_json(value: object) -> object:
    if isinstance(value, Message):
        return value.as_row()
    if isinstance(value, tuple) and all(isinstance(each, Message) for each in value):
        return [each.as_row() for each in value]
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else f"{value:g}"
    return value if isinstance(value, int) else str(value)


def _of_json(value: object) -> object:
    if isinstance(value, list):
        return tuple(map(Message.of_row, value))
    return Message.of_row(value) if isinstance(value, dict) else value
