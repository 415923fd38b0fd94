"""Judging raytrace alone: what it does with the rays of camera_ray and the colours of trace_ray.

A probe stands in the place of trace_ray, whose colour tells the direction of the ray: the picture
can be judged before trace_ray is written, or while it is wrong. Who does without a trace_ray of
their own there is judged with their functions as they are.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass

import numpy as np

from grader.checking.comparison import far
from grader.checking.describe import pair
from grader.checking.expected_data import SIZE, Array, Batch
from grader.checking.looks import Look
from grader.checking.observations import Observations
from grader.checking.pictures import views, whole
from grader.checking.records import Evidence
from grader.checking.reproducer import of_command
from grader.checking.shapes import Image
from grader.checking.student import Bench, CallDied, Student, Wrong, without_answers
from grader.course.message import Message
from grader.execution.library_set import NotBuilt

UNWRITTEN = -1.0  # of every channel, before raytrace
MOST = 0.5  # of the pixels
FLAT = 1e-3  # a picture that varies by less has one colour
COLORS = 4  # fewer are painted, and come from no ray


@dataclass(frozen=True)
class Drawn:
    """A picture of raytrace, and what it should be, each of shape (height, width, 3).

    `centre` is made of rays through (i + 0.5, j + 0.5), `corner` through (i, j): both of the
    submission's own camera_ray, and of its trace_ray or the probe.
    """

    batch: Batch
    picture: Image
    centre: Image
    corner: Image

    def compare(self, expected: Image) -> None:
        """Raise Wrong at the first pixel that is not as expected."""
        if np.ptp(expected.reshape(-1, 3), axis=0).max() < FLAT:
            raise Wrong("failure.flat_picture")
        wrong = far(_flat(self.picture), _flat(expected), self.batch.tolerance) & self._written()
        if not wrong.any():
            return
        j, i = divmod(int(np.flatnonzero(wrong)[0]), SIZE[0])
        values = pair(self.picture[j, i], expected[j, i])
        complaint = Wrong("failure.picture", i=i, j=j, **values)
        if turned := whole.turned(self.picture, expected, self.batch.tolerance):
            complaint = Wrong(turned)
        raise complaint.showing(self._evidence(i, j, expected))

    def _written(self) -> Array:
        """Return which pixels are written; all where few are: those left are asked of elsewhere."""
        written: Array = (_flat(self.picture) != UNWRITTEN).any(axis=1)
        return written if written.mean() > MOST else np.ones(len(written), bool)

    def _evidence(self, i: int, j: int, expected: Image) -> Evidence:
        """Return the C program that draws the picture and looks at a pixel; and the pictures."""
        look = Look(f"output_image[{j} * WIDTH + {i}]", expected[j, i])
        outside = np.abs(self.picture - expected).max(axis=2)
        outside = np.nan_to_num(outside, nan=1.0, posinf=1.0)
        return Evidence(
            reproducer=of_command("raytrace", [], self.batch, look),
            images=views.images(self.picture, expected, outside, (j, i)),
        )


def check(student: Student, look: Callable[[Drawn], None]) -> None:
    """Look at the picture of raytrace. Raises Wrong, Fatal."""
    drawn: list[Drawn] = []

    def look_at(picture: Drawn) -> None:
        drawn.append(picture)
        look(picture)

    try:
        look_at(student.once("raytrace", lambda asked: _drawn(asked, asked.probe())))
    except NotBuilt:
        look_at(_drawn(student, student.bench()))
    except (Wrong, CallDied) as first:
        noted, student.observations = student.observations, Observations()
        try:
            look_at(_drawn(student, student.bench()))
        except (Wrong, CallDied) as second:
            if len(drawn) == 2 and np.array_equal(drawn[0].picture, drawn[1].picture):
                raise second from None  # trace_ray is not called
            student.observations = noted
            if isinstance(first, Wrong):
                student.remarks.append(Message("note.probe"))
            raise first from None


def note(student: Student, drawn: Drawn, expected: Image) -> None:
    """Put down what is wrong at some pixels, those of the stored positions."""
    i, j = (np.floor(drawn.batch.args[name]).astype(int) for name in ("x", "y"))
    got, right = drawn.picture[j, i], expected[j, i]
    tolerance = drawn.batch.tolerance
    student.observations.note("picture", got, far(got, right, tolerance), tolerance)


def _drawn(student: Student, session: AbstractContextManager[Bench]) -> Drawn:
    (batch,) = student.batches("raytrace")
    with session as bench:
        return _drawn_on(bench, batch)


def _drawn_on(bench: Bench, batch: Batch) -> Drawn:
    bench.trial(without_answers(batch))  # sets the scene and the camera
    size = (SIZE[1], SIZE[0], 3)
    j, i = np.divmod(np.arange(SIZE[0] * SIZE[1]), SIZE[0])
    corners = [each.astype(np.float32) for each in (i, j)]
    centre = bench.colors(*(each + np.float32(0.5) for each in corners))
    corner = bench.colors(*corners)
    bench.session.set("output_image", np.full((SIZE[0] * SIZE[1], 3), UNWRITTEN, np.float32))
    bench.call("raytrace", "raytrace()")
    picture = bench.session.get("output_image").reshape(size)
    return Drawn(batch, picture, centre.reshape(size), corner.reshape(size))


def is_painted(picture: Image) -> bool:
    """Whether a picture has so few colours that they come from no ray."""
    return len(np.unique(np.round(_flat(picture) / FLAT), axis=0)) < COLORS


def _flat(picture: Image) -> Array:
    """Return the pixels as rows, shape (height * width, 3)."""
    return picture.reshape(-1, 3)
