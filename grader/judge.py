"""What the checks are written with: calling the student's functions, and comparing in the parent.

A check gets a `Student`, runs cases in its sessions, and raises `Wrong` when an answer is not
right. TP1's checks draw on a `Canvas`, case by case from the simplest on; those of TP2 to TP5 put
stored inputs to a function, all in one message (`Student.trials`), or do more on a `Bench`.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from grader import expected, show
from grader.compare import Trial, Wrong
from grader.expected import Answer, Array, Batch
from grader.records import Cause, Death, Verdict
from grader.runner import Address, Core, Died, Limits, Session
from grader.shapes import Image, Mask, Region, Size

# With what checks need of compare.py.
__all__ = ["Bench", "Canvas", "Fatal", "Student", "Trial", "Wrong", "shown"]

T = TypeVar("T")

SIZES: tuple[Size, ...] = ((320, 180), (96, 64))
UNIT_LIMITS = Limits(cpu=2.0)
PICTURE_SIZE: Size = (320, 180)
PICTURE_LIMITS = Limits(cpu=10.0)
# Colours are copied, or computed by an expression or two of floats.
COPIED = 1e-5
# One level of the picture file: float and double round a gradient differently.
ONE_LEVEL = 1 / 255


def sizes_for(tp: int | None) -> tuple[Size, ...]:
    """Return the sizes that the checks of a TP (None: of all) draw at; each is a build.

    Only TP1's are run at both; the data of the others was made for one.
    """
    return SIZES if tp in (None, 1) else (expected.SIZE,)


class Fatal(Exception):
    """The student's code did not come back from a call."""

    def __init__(self, death: Death, call: str) -> None:
        super().__init__(call)
        self.death, self.call = death, call


class Student:
    """The submission, as one check sees it: sessions by picture size, and what they left behind."""

    def __init__(
        self,
        cores: Mapping[Size, Core],
        renderer: Core,
        stuck: dict[str, Death],
        folder: Path = expected.FOLDER,
    ) -> None:
        self._cores, self._renderer = cores, renderer
        self._stuck = stuck  # functions that have run out of time, in this check or an earlier one
        self._folder = folder  # of the expected data
        self.todo: frozenset[str] = frozenset()
        self.output = ""  # what was printed in the first session that printed something
        self.remarks: list[Verdict] = []  # what to tell besides, whatever the outcome

    @contextlib.contextmanager
    def canvas(self, size: Size) -> Iterator[Canvas]:
        """Start a session in which pictures of that size are drawn."""
        with self._session(size) as session:
            yield Canvas(self, session, size)

    @contextlib.contextmanager
    def bench(self) -> Iterator[Bench]:
        """Start a session for functions that are not TP1's."""
        with self._session(expected.SIZE) as session:
            yield Bench(self, session, self._cores[expected.SIZE])

    def batches(self, suite: str) -> list[Batch]:
        """Return the stored calls of a suite, with the answers that are accepted."""
        return expected.read(self._folder, suite, self._cores[expected.SIZE])

    def trials(self, suite: str) -> list[Trial]:
        """Put a suite to the submission: all its calls, in one session."""
        with self.bench() as bench:
            return [bench.trial(batch) for batch in self.batches(suite)]

    def picture(self, scene: int, **settings: Any) -> Image:
        """Draw a scene with the optimised build; `settings` are fields of `options`.

        Returns shape (180, 320, 3), float32, row 0 at the bottom, as it was left. Raises Fatal.
        """
        core = self._renderer
        text = ", ".join(
            [f"scene {scene}", *(f"{key} = {value}" for key, value in settings.items())]
        )
        with self._open(core, PICTURE_LIMITS) as session:
            options = session.get("options")
            for name, value in settings.items():
                options[name] = value
            session.set("options", options)
            session.call("setup_scene", scene)
            self.guard(
                "raytrace", lambda case: f"raytrace() ({text})", lambda: session.call("raytrace")
            )
            flat = session.get("output_image")
        return flat.reshape(PICTURE_SIZE[1], PICTURE_SIZE[0], 3)

    def guard(self, name: str, call: Callable[[int], str], act: Callable[[], T]) -> T:
        """Run code that calls a function; `call` gives the text of its calls by their number.

        Raises Fatal when it does not come back; at once when it has run out of time before.
        """
        if name in self._stuck:
            raise Fatal(self._stuck[name], call(0))
        try:
            return act()
        except Died as error:
            if error.death.cause is Cause.TIMEOUT:
                self._stuck[name] = error.death
            raise Fatal(error.death, call(error.death.case)) from error

    @contextlib.contextmanager
    def _session(self, size: Size) -> Iterator[Session]:
        with self._open(self._cores[size], UNIT_LIMITS) as session:
            yield session

    @contextlib.contextmanager
    def _open(self, core: Core, limits: Limits) -> Iterator[Session]:
        with core.session(limits) as session:
            try:
                yield session
            finally:
                self.todo |= session.todo()
                self.output = self.output or session.output()


class Bench:
    """A session in which functions are called in a given setting."""

    def __init__(self, student: Student, session: Session, core: Core) -> None:
        self._student, self.session, self.core = student, session, core

    def trial(self, batch: Batch) -> Trial:
        """Make the calls of a batch in its setting. Raises Fatal."""
        expected.prepare(self.session, self.core, batch)
        return self.again(batch)

    def again(self, batch: Batch, **addresses: Address) -> Trial:
        """Make the calls of a batch in the setting as it stands. Raises Fatal.

        `addresses` are arguments that all the calls share.
        """
        parameters = self.core.functions[batch.function].parameters
        only_written = ("it", "out", "r") if batch.function == "camera_ray" else ("it", "out")
        hidden = tuple(
            each.name
            for each in parameters
            if each.name in only_written and expected.is_written(each.ctype)
        )

        def text(case: int) -> str:
            return show.call(batch, min(case, batch.count - 1), hidden)

        def act() -> Answer:
            return expected.run(self.session, self.core, batch, **addresses)

        return Trial(batch, self._student.guard(batch.function, text, act), hidden)

    def colors(self, x: Array, y: Array) -> Array:
        """Return what the submission's own trace_ray gives through positions, shape (n, 3).

        The rays are those of its own camera_ray.
        """
        rays = self.core.zeros("ray", len(x))
        seen = self.again(Batch("camera_ray", {"r": rays, "x": x, "y": y}, {}))
        traced = self.again(Batch("trace_ray", {"r": seen.got("r")}, {}))
        return traced.got("result")

    def call(self, name: str, text: str, *args: Any) -> Any:
        """Call a function once and return its result; `text` is the call. Raises Fatal."""
        reply = self._student.guard(name, lambda case: text, lambda: self.session.call(name, *args))
        return reply.result


def without_answers(batch: Batch, **args: Array) -> Batch:
    """Return the batch with other arguments, and nothing expected."""
    return replace(batch, args={**batch.args, **args}, answers=())


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
        reply = self._student.guard(
            name, lambda case: call, lambda: self._session.call(name, flat, *args.values())
        )
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
