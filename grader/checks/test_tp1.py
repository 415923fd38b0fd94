"""TP1 - images: the functions of main.c, on pictures of two sizes.

Every check starts from a picture of noise, so that a pixel left alone is told from one drawn, and
goes through its cases from the simplest on. What is expected is computed here, never in the
student's process.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest

from grader.checking import describe, shapes
from grader.checking.canvas import ONE_LEVEL, Canvas, Drawing
from grader.checking.shapes import Image
from grader.checking.student import SIZES, Student, Wrong

Point = tuple[float, float, float]
Box = tuple[float, float, float, float]  # x1, y1, x2, y2: two opposite corners, pixels
Circle = tuple[float, float, float]  # radius, x, y, pixels

RED, YELLOW = (1.0, 0.0, 0.0), (1.0, 1.0, 0.0)
BLUE, WHITE = (0.0, 0.0, 1.0), (1.0, 1.0, 1.0)


def canvases(student: Student) -> Iterator[Canvas]:
    """Both sizes in turn: a size written into the code, or H for W, shows on one of them."""
    for size in SIZES:
        with student.canvas(size) as canvas:
            yield canvas


def random_numbers(seed: int, *shape: int) -> list[list[float]]:
    """Return numbers between 0 and 1, the same in every run."""
    rows: list[list[float]] = np.random.default_rng(seed).uniform(0, 1, shape).tolist()
    return rows


@pytest.mark.check("tp1.fill_red.color")
def test_fill_red_color(student: Student) -> None:
    """The picture is red, but for a few pixels."""
    for canvas in canvases(student):
        canvas.draw("fill_red", canvas.noise()).expect_nearly(shapes.flat(canvas.size, RED))


@pytest.mark.check("tp1.fill_red.every_pixel")
def test_fill_red_every_pixel(student: Student) -> None:
    """Every pixel is red, each time."""
    for canvas in canvases(student):
        for _ in range(2):
            canvas.draw("fill_red", canvas.noise()).expect(shapes.flat(canvas.size, RED))


@pytest.mark.check("tp1.fill_color.color")
def test_fill_color_color(student: Student) -> None:
    """The picture takes the colour that is given, but for a few pixels."""
    for canvas in canvases(student):
        for c in [[0.25, 0.5, 0.75], *random_numbers(2, 3, 3)]:
            drawing = canvas.draw("fill", canvas.noise(), c=c)
            drawing.expect_nearly(shapes.flat(canvas.size, c), ONE_LEVEL)


@pytest.mark.check("tp1.fill_color.every_pixel")
def test_fill_color_every_pixel(student: Student) -> None:
    """Every pixel takes the colour that is given."""
    for canvas in canvases(student):
        for c in [[0.25, 0.5, 0.75], *random_numbers(2, 3, 3)]:
            drawing = canvas.draw("fill", canvas.noise(), c=c)
            drawing.expect(shapes.flat(canvas.size, c), ONE_LEVEL)


@pytest.mark.check("tp1.fill_color.as_it_is")
def test_fill_color_as_it_is(student: Student) -> None:
    """A colour is copied as it is, even where it is not between 0 and 1."""
    for canvas in canvases(student):
        c = [1.5, -0.25, 2]
        drawing = canvas.draw("fill", canvas.noise(), c=c)
        drawing.expect_where_drawn(shapes.flat(canvas.size, c))


@pytest.mark.check("tp1.horizontal_gradient.direction")
def test_horizontal_gradient_direction(student: Student) -> None:
    """The first colour is at the top, the second at the bottom."""
    for canvas in canvases(student):
        drawing = canvas.draw("horizontal_gradient", canvas.noise(), c1=BLUE, c2=WHITE)
        height = canvas.size[1]
        # Not at the ends themselves: that every row is drawn is asked of `rows`.
        for j, wanted, other in ((height - 2, BLUE, WHITE), (1, WHITE, BLUE)):
            got = drawing.after[j, 0]
            # How the colours are mixed is asked of `rows` too.
            away, back = (np.linalg.norm(got - np.array(each)) for each in (wanted, other))
            if not away < back:
                values = describe.pair(got, np.array(wanted))
                wrong = Wrong("failure.end", call=drawing.call, j=j, height=height, **values)
                whole = shapes.gradients(canvas.size, BLUE, WHITE)[0]
                raise wrong.showing(drawing.evidence(0, j, wanted, whole))


@pytest.mark.check("tp1.horizontal_gradient.rows")
def test_horizontal_gradient_rows(student: Student) -> None:
    """Each row has one colour, mixed in proportion to its height."""
    for canvas in canvases(student):
        for c1, c2 in [(BLUE, WHITE), (RED, [0.25, 0.5, 0.75]), random_numbers(4, 2, 3)]:
            drawing = canvas.draw("horizontal_gradient", canvas.noise(), c1=c1, c2=c2)
            # Upside down it is mixed as well: which end is which is asked of `direction`.
            accepted = shapes.gradients(canvas.size, c1, c2)
            accepted += shapes.gradients(canvas.size, c2, c1)
            drawing.expect(nearest(drawing.after, accepted), ONE_LEVEL)


def nearest(got: Image, accepted: list[Image]) -> Image:
    """Return the accepted picture whose worst difference is smallest; a NaN is as far as can be."""
    return min(accepted, key=lambda each: np.nan_to_num(np.abs(got - each), nan=np.inf).max())


def colors() -> Iterator[tuple[list[float] | Point, float]]:
    """Yield colours and heights z, which is ignored: yellow and 0 first."""
    yield YELLOW, 0.0
    for r, g, b, z in random_numbers(7, 9, 4):
        yield [round(each, 2) for each in (r, g, b)], round(9 * z)


def check_boxes(student: Student, cases: Callable[[int, int], list[Box]]) -> None:
    """Draw rectangles, one at a time; `cases` gives them from the picture's width and height."""
    for canvas in canvases(student):
        for (x1, y1, x2, y2), (c, z) in zip(cases(*canvas.size), colors(), strict=False):
            p1, p2 = (x1, y1, z), (x2, y2, -z)
            drawing = canvas.draw("fill_rect", canvas.noise(), c=c, p1=p1, p2=p2)
            drawing.expect_region(c, shapes.rectangle(canvas.size, p1, p2))


@pytest.mark.check("tp1.fill_rect.inside")
def test_fill_rect_inside(student: Student) -> None:
    """A rectangle inside the picture is filled, and nothing else."""

    def cases(w: int, h: int) -> list[Box]:
        corners = [
            (w * a // 2, h * b // 2, w // 2 + w * c // 2, h // 2 + h * d // 2)
            for a, b, c, d in random_numbers(5, 3, 4)
        ]
        return [(10, 20, 30, 40), *corners, (5, 5, 5, 5)]

    check_boxes(student, cases)


@pytest.mark.check("tp1.fill_rect.fractions")
def test_fill_rect_fractions(student: Student) -> None:
    """Corners between pixels count by their whole parts, each by its own."""
    boxes = [(10.7, 20.6, 30.2, 40.3), (10.2, 20.3, 30.9, 40.8), (5.8, 7.6, 6.1, 8.1)]
    for canvas in canvases(student):
        whole = canvas.draw("fill_rect", canvas.noise(), c=YELLOW, p1=(10, 20, 0), p2=(30, 40, 0))
        # Upper sides may be left out, but then of every rectangle.
        has_sides = bool((whole.after[40, 30] == YELLOW).all())
        for x1, y1, x2, y2 in boxes:
            p1, p2 = (x1, y1, 0), (x2, y2, 0)
            drawing = canvas.draw("fill_rect", canvas.noise(), c=YELLOW, p1=p1, p2=p2)
            region = shapes.rectangle(canvas.size, p1, p2, [has_sides])
            drawing.expect_region(YELLOW, region)


@pytest.mark.check("tp1.fill_rect.corner_order")
def test_fill_rect_corner_order(student: Student) -> None:
    """The two corners may come in any order."""
    check_boxes(
        student,
        lambda w, h: [(30, 20, 10, 40), (10, 40, 30, 20), (30, 40, 10, 20), (h - 9, h - 1, 1, 1)],
    )


@pytest.mark.check("tp1.fill_rect.clipped")
def test_fill_rect_clipped(student: Student) -> None:
    """Of a rectangle that leaves the picture, the part inside is drawn."""
    check_boxes(
        student,
        lambda w, h: [
            (10, -5, 20, 8),
            (10, h - 8, 20, h + 5),
            (-5, 10, 8, 20),
            (w - 8, 10, w + 5, 20),
            (0, 0, w, h),
            (-w, -h, 2 * w, 2 * h),
            (0, 0, 1, 1),
        ],
    )


@pytest.mark.check("tp1.fill_rect.off_screen")
def test_fill_rect_off_screen(student: Student) -> None:
    """A rectangle outside the picture changes nothing."""
    check_boxes(
        student,
        lambda w, h: [
            (w, 10, w + 20, 20),
            (-20, 10, -1, 20),
            (10, h, 20, h + 20),
            (10, -20, 20, -1),
            (-3 * w, -3 * h, -2 * w, -2 * h),
        ],
    )


def check_circles(
    student: Student, cases: Callable[[int, int], list[Circle]], *, strict: bool = False
) -> None:
    """Draw discs, one at a time; `cases` gives them from the picture's width and height."""
    for drawing, color, radius, center in circles(student, cases):
        size = (drawing.after.shape[1], drawing.after.shape[0])
        drawing.expect_region(color, shapes.disc(size, radius, center, strict=strict))


def circles(
    student: Student, cases: Callable[[int, int], list[Circle]]
) -> Iterator[tuple[Drawing, list[float] | Point, float, Point]]:
    """Yield drawings of discs, each with its colour, radius and centre."""
    for canvas in canvases(student):
        for (radius, x, y), (color, z) in zip(cases(*canvas.size), colors(), strict=False):
            center = (x, y, z)
            args = {"radius": radius, "center": center, "c": color}
            yield canvas.draw("fill_circle", canvas.noise(), **args), color, radius, center


def discs(w: int, h: int) -> list[Circle]:
    """Return discs inside the picture."""
    random = [
        (h * (0.1 + 0.1 * a), w * (0.3 + 0.4 * b), h * (0.3 + 0.4 * c))
        for a, b, c in random_numbers(6, 4, 3)
    ]
    return [(10, 40, 30), (1, 5, 7), *random]


# What is not of the disc within so many pixels of its rim, and so large a share of holes, is asked
# of `exact`: whoever sweeps angles draws a disc too.
RIM, HOLES = 1.5, 0.3


@pytest.mark.check("tp1.fill_circle.inside")
def test_fill_circle_inside(student: Student) -> None:
    """A disc inside the picture is drawn, of its radius and around its centre."""
    for drawing, color, radius, center in circles(student, discs):
        size = (drawing.after.shape[1], drawing.after.shape[0])
        inner, outer = (shapes.disc(size, radius + each, center) for each in (-RIM, RIM))
        left = inner.sure & (drawing.after == drawing.before).all(axis=2)
        if left.sum() > HOLES * inner.sure.sum():
            drawing.expect_region(color, shapes.disc(size, radius, center))
        drawing.expect_region(color, shapes.PixelRegion(inner.sure & ~left, outer.maybe))


@pytest.mark.check("tp1.fill_circle.exact")
def test_fill_circle_exact(student: Student) -> None:
    """All the disc's pixels are drawn, and no other."""
    check_circles(student, discs)


@pytest.mark.check("tp1.fill_circle.rim")
def test_fill_circle_rim(student: Student) -> None:
    """A pixel exactly at the radius is out, and a radius of zero draws nothing."""
    check_circles(
        student,
        lambda w, h: [(5, 40, 30), (13, w // 2, h // 2), (0, 20, 20)],
        strict=True,
    )


@pytest.mark.check("tp1.fill_circle.clipped")
def test_fill_circle_clipped(student: Student) -> None:
    """Of a disc that leaves the picture, the part inside is drawn."""
    check_circles(
        student,
        lambda w, h: [
            (10, 0, 30),
            (10, w, 30),
            (10, 40, 0),
            (10, 40, h),
            (12, -4, -4),
            (12, w + 4, h + 4),
            (2 * w, w // 2, h // 2),
            (1, 0, 0),
        ],
    )


@pytest.mark.check("tp1.fill_circle.off_screen")
def test_fill_circle_off_screen(student: Student) -> None:
    """A disc outside the picture changes nothing."""
    check_circles(
        student, lambda w, h: [(10, w + 30, 30), (10, -30, 30), (10, 40, h + 30), (10, 40, -30)]
    )
