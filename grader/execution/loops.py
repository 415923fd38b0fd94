"""Which functions do not come back, so that their time is not spent again in every check."""

from __future__ import annotations

from dataclasses import dataclass

from grader.execution.records import Death

LOOPS = 2  # of who has come back from other calls: after so many it is not called again either


@dataclass(frozen=True)
class Loop:
    """A call that has run out of time: its text, and as a C program."""

    death: Death
    call: str
    program: str


class Loops:
    """The loops of one submission, by function.

    Who has never come back is called once; who has, as a function that loops on some arguments
    alone, gets a second chance, so that one wrong loop does not cost what is right beside it.
    """

    def __init__(self) -> None:
        self._found: dict[str, list[Loop]] = {}
        self._back: set[str] = set()

    def come_back(self, name: str) -> None:
        """Note that a function has come back from its calls."""
        self._back.add(name)

    def add(self, name: str, loop: Loop) -> None:
        """Note a call of a function that has run out of time."""
        self._found.setdefault(name, []).append(loop)

    def of(self, name: str, chances: int = LOOPS) -> Loop | None:
        """Return the loop for which a function is not called again; None: it is to be called."""
        found = self._found.get(name, [])
        enough = chances if name in self._back else 1
        return found[-1] if len(found) >= enough else None
