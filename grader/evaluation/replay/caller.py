"""Where a submission's functions are called one by one: a session, and the scene that it has."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

from grader.checking.expected_data import Array
from grader.execution.session import Library, Session

T = TypeVar("T")


class Caller(Protocol):
    """Where functions are called, in a session that has its scene and its options."""

    def ask(self, name: str, act: Callable[[Session, Library], T]) -> T:
        """Let `act` use the session; `name` is the function that it calls, for messages."""


@dataclass(frozen=True)
class Content:
    """A scene and its options, as they stand in a session: arrays of C's structs."""

    objects: Array
    lights: Array
    camera: Any
    options: Any
