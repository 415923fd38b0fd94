"""Drawing with TP1's functions, case by case, and looking at the pixels."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, Protocol, TypeVar

import numpy as np

from grader.checking import reproducer
from grader.checking.comparison import Wrong
from grader.checking.describe import pair, value
from grader.checking.observations import Observations
from grader.checking.records import Evidence
from grader.checking.shapes import Image, Mask, PixelRegion, Size, in_every_channel
from grader.execution.session import Session

T = TypeVar("T")

# Colours are copied, or computed by an expression or two of floats.
COPIED = 1e-5
# One level of the picture file: float and double round a gradient differently.
ONE_LEVEL = 1 / 255
# Of the pixels of a picture: as many as a loop leaves out that ends too early or begins too late.
FEW, HALF = 0.01, 0.5
# What stands for a pixel that was not drawn, in the pictures that are shown.
_UNTOUCHED = np.float32(0.82)
# Of a drawing, every so many rows and columns are put down.
_SPARSE = 16


class Guard(Protocol):
    """What runs code that calls a function, and says what becomes of it: Student.guard."""

    def __call__(
        self,
        name: str,
        call: Callable[[int], str],
        act: Callable[[], T],
        program: Callable[[int], str],
    ) -> T:
        """Return what `act` does."""


class Canvas:
    """A session in which TP1's functions draw on pictures of one size."""

    def __init__(
        self, guard: Guard, observations: Observations, session: Session, size: Size
    ) -> None:
        self._guard, self._observations, self._session = guard, observations, session
        self.size = size

    def noise(self) -> Image:
        """Return a picture whose every pixel differs from its neighbours and from what is drawn."""
        return _noise(self.size)

    def draw(self, name: str, before: Image, **args: Any) -> Drawing:
        """Call a function on a copy of a picture; `args` are its other parameters, in order."""
        values = "".join(f", {key} = {value(each)}" for key, each in args.items())
        call = f"{name}(img{values})"
        flat = before.reshape(-1, 3)
        reply = self._guard(
            name,
            lambda case: call,
            lambda: self._session.call(name, flat, *args.values()),
            lambda case: reproducer.of_drawing(name, self.size, [*args.values()]),
        )
        after = reply.args["img"].reshape(before.shape)
        return Drawing(name, tuple(args.values()), call, before, after, self._observations)


@dataclass(frozen=True)
class Drawing:
    """A call, as the student would write it, with the picture before and after."""

    name: str
    args: tuple[Any, ...]
    call: str
    before: Image
    after: Image
    observations: Observations

    def expect(self, expected: Image, tolerance: float = COPIED) -> None:
        """Raise Wrong at the first pixel that is not as expected."""
        wrong = self._wrong(expected, tolerance)
        if wrong.any():
            self._note(wrong)
            self._complain("wrong_pixel", wrong, expected, expected)

    def expect_nearly(self, expected: Image, tolerance: float = COPIED) -> None:
        """Raise Wrong at the first pixel that is not as expected, unless there are few of them."""
        if self._wrong(expected, tolerance).mean() > FEW:
            self.expect(expected, tolerance)

    def expect_where_drawn(self, expected: Image) -> None:
        """Raise Wrong unless what was drawn is as expected; half of the picture at least was."""
        left = in_every_channel(self.after == self.before)
        if left.mean() <= HALF:
            expected = np.where(left[..., None], self.before, expected)
        self.expect(expected)

    def _wrong(self, expected: Image, tolerance: float) -> Mask:
        """Return the pixels that are not as expected; a NaN is none of what is."""
        wrong: Mask = ~in_every_channel(np.abs(self.after - expected) <= tolerance)
        return wrong

    def expect_region(self, color: Any, region: PixelRegion) -> None:
        """Raise Wrong unless the region, and nothing else, has taken the colour."""
        wanted = np.broadcast_to(np.asarray(color, np.float32), self.after.shape)
        drawn = in_every_channel(np.abs(self.after - wanted) <= COPIED)
        kept = in_every_channel(self.after == self.before)
        for key, wrong in (
            ("missed_pixel", region.sure & ~drawn),
            ("touched_pixel", ~region.maybe & ~kept),
            ("wrong_pixel", ~drawn & ~kept),
        ):
            if wrong.any():
                self._note(~kept)
                # Where both are accepted, what was drawn is.
                free = region.maybe & ~region.sure & (drawn | kept)
                right = np.where(region.sure[..., None], wanted, self.before)
                self._complain(key, wrong, wanted, np.where(free[..., None], self.after, right))

    def _note(self, pixels: Mask) -> None:
        """Put down which pixels matter, and a few of the colours."""
        self.observations.note_mask(f"{self.call} pixels", pixels)
        few = self.after[::_SPARSE, ::_SPARSE]
        self.observations.note(f"{self.call} colours", few[None], np.ones(1, bool), ONE_LEVEL)

    def _complain(self, key: str, wrong: Mask, expected: Image, whole: Image) -> None:
        """Raise Wrong at the first pixel that is; `whole` is the picture that was expected."""
        height, width = wrong.shape
        j, i = (int(each) for each in np.argwhere(wrong)[0])
        right = self.before[j, i] if key == "touched_pixel" else expected[j, i]
        texts = pair(self.after[j, i], right)
        complaint = Wrong(
            f"failure.{key}",
            call=self.call,
            i=i,
            j=j,
            width=width,
            height=height,
            before=texts["expected"],
            **texts,
        )
        raise complaint.showing(self.evidence(i, j, right, whole))

    def evidence(self, i: int, j: int, expected: Any, whole: Image | None = None) -> Evidence:
        """Return the C program that makes the call and looks at a pixel, and the pictures."""
        height, width = self.before.shape[:2]
        before = self.before[j, i]
        program = reproducer.of_drawing(
            self.name, (width, height), self.args, (i, j), before, expected
        )
        return Evidence(
            reproducer=program, images={} if whole is None else self._images(i, j, whole)
        )

    def _images(self, i: int, j: int, expected: Image) -> Mapping[str, bytes]:
        """Return the pictures side by side, what nobody has drawn in grey; none when all is.

        The noise that stands there says nothing to a reader, and no file format makes it small.
        """
        kept = in_every_channel(self.after == self.before)
        if kept.all():
            return {}
        from grader.checking.pictures import views

        got = np.where(kept[..., None], _UNTOUCHED, self.after)
        left = in_every_channel(expected == self.before)
        right = np.where(left[..., None], _UNTOUCHED, expected)
        outside = np.abs(np.nan_to_num(got, nan=2.0, posinf=2.0, neginf=-2.0) - right).max(axis=2)
        return views.images(got, right, outside, views.tile_around(j, i, outside.shape))


@cache
def _noise(size: Size) -> Image:
    picture = np.random.default_rng(1).uniform(0.05, 0.95, (size[1], size[0], 3))
    return picture.astype(np.float32)
