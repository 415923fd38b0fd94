"""A sentence for a person by its key in messages/, said or raised."""

from __future__ import annotations

from dataclasses import dataclass, field


class UserError(Exception):
    """An error with a sentence for the person at the terminal, by its key in messages/."""

    def __init__(self, key: str, **values: object) -> None:
        super().__init__(f"{key}: {values}")
        self.key = key
        self.values = values


@dataclass(frozen=True)
class Message:
    """What is wrong: the sentence of `key` in messages/, with its values."""

    key: str
    values: dict[str, object] = field(default_factory=dict)
