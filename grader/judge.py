"""What the checks are written with: calling the student's functions, and comparing in the parent.

A check gets a `Student`, runs cases in its sessions, and raises `Wrong` at the first case whose
answer is not right: cases stand from the simplest to the most complex, so the first is the one to
show.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from grader.records import Cause, Death, Verdict
from grader.runner import Core, Died, Limits, Reply, Session
from grader.shapes import Image, Mask, Region, Size

SIZES: tuple[Size, ...] = ((320, 180), (96, 64))
UNIT_LIMITS = Limits(cpu=2.0)
# Colours are copied, or computed by an expression or two of floats.
COPIED = 1e-5
# One level of the picture file: float and double round a gradient differently.
ONE_LEVEL = 1 / 255


class Wrong(Exception):
    """The answer is not right; `verdict` says what came instead."""

    def __init__(self, key: str, **values: object) -> None:
        super().__init__(key)
        self.verdict = Verdict(key, values)


class Fatal(Exception):
    """The student's code did not come back from a call."""

    def __init__(self, death: Death, call: str) -> None:
        super().__init__(call)
        self.death, self.call = death, call


class Student:
    """The submission, as one check sees it: sessions by picture size, and what they left behind."""

    def __init__(self, cores: Mapping[Size, Core], stuck: dict[str, Death]) -> None:
        self._cores = cores
        self._stuck = stuck  # functions that have run out of time, in this check or an earlier one
        self.todo: frozenset[str] = frozenset()

    @contextlib.contextmanager
    def canvas(self, size: Size) -> Iterator[Canvas]:
        """Start a session in which pictures of that size are drawn."""
        with self._cores[size].session(UNIT_LIMITS) as session:
            try:
                yield Canvas(self, session, size)
            finally:
                self.todo |= session.todo()

    def run(self, session: Session, call: str, name: str, *args: Any) -> Reply:
        """Call a function. Raises Fatal; at once when the function has run out of time before."""
        if name in self._stuck:
            raise Fatal(self._stuck[name], call)
        try:
            return session.call(name, *args)
        except Died as error:
            if error.death.cause is Cause.TIMEOUT:
                self._stuck[name] = error.death
            raise Fatal(error.death, call) from error


class Canvas:
    """A session in which TP1's functions draw on pictures of one size."""

    def __init__(self, student: Student, session: Session, size: Size) -> None:
        self._student, self._session = student, session
        self.size = size

    def noise(self) -> Image:
        """Return a picture whose every pixel differs from its neighbours and from what is drawn."""
        return _noise(self.size)

    def draw(self, name: str, before: Image, **args: Any) -> Drawing:
        """Call a function on a copy of a picture; `args` are its other parameters, in order."""
        values = "".join(f", {key} = {shown(value)}" for key, value in args.items())
        call = f"{name}(img{values})"
        flat = before.reshape(-1, 3)
        reply = self._student.run(self._session, call, name, flat, *args.values())
        return Drawing(call, before, reply.args["img"].reshape(before.shape))


@dataclass(frozen=True)
class Drawing:
    """A call, as the student would write it, with the picture before and after."""

    call: str
    before: Image
    after: Image

    def expect(self, expected: Image, tolerance: float = COPIED) -> None:
        """Raise Wrong at the first pixel that is not as expected."""
        # Written so that a NaN is wrong.
        wrong = ~(np.abs(self.after - expected) <= tolerance).all(axis=2)
        if wrong.any():
            self._complain("wrong_pixel", wrong, expected)

    def expect_region(self, color: Any, region: Region) -> None:
        """Raise Wrong unless the region, and nothing else, has taken the colour."""
        wanted = np.broadcast_to(np.asarray(color, np.float32), self.after.shape)
        drawn = (np.abs(self.after - wanted) <= COPIED).all(axis=2)
        kept = (self.after == self.before).all(axis=2)
        for key, wrong in (
            ("missed_pixel", region.sure & ~drawn),
            ("touched_pixel", ~region.maybe & ~kept),
            ("wrong_pixel", ~drawn & ~kept),
        ):
            if wrong.any():
                self._complain(key, wrong, wanted)

    def _complain(self, key: str, wrong: Mask, expected: Image) -> None:
        height, width = wrong.shape
        j, i = (int(each) for each in np.argwhere(wrong)[0])
        raise Wrong(
            f"failure.{key}",
            call=self.call,
            i=i,
            j=j,
            width=width,
            height=height,
            got=shown(self.after[j, i]),
            expected=shown(expected[j, i]),
            before=shown(self.before[j, i]),
        )


@cache
def _noise(size: Size) -> Image:
    picture = np.random.default_rng(1).uniform(0.05, 0.95, (size[1], size[0], 3))
    return picture.astype(np.float32)


def shown(value: Any) -> str:
    """Return a number, or a triple of them, as short as it can be told."""
    flat = np.ravel(np.asarray(value, np.float64))
    text = ", ".join(f"{each:.4g}" for each in flat)
    return f"({text})" if flat.size > 1 else text
