"""TP1's functions against their definitions, pixel by pixel, at the picture's edges and beyond."""

from __future__ import annotations

import numpy as np
import pytest

from grader.execution.session import Session
from grader.tests.core.oracles import Array

WIDTH, HEIGHT = 96, 64
PIXELS = WIDTH * HEIGHT
COLOR = (0.25, 0.5, 2.0)
ROW, COLUMN = np.indices((HEIGHT, WIDTH))
HUGE = 3e38


def before(rng: np.random.Generator) -> Array:
    """Return a picture of noise, so that every pixel that is written shows."""
    return rng.random((PIXELS, 3)).astype(np.float32)


def painted(img: Array, mask: Array) -> Array:
    """Return the picture with COLOR where the mask is true; shape (PIXELS, 3)."""
    return np.where(mask.reshape(PIXELS, 1), np.array(COLOR, np.float32), img)


def test_fill_red_and_fill(s: Session, rng: np.random.Generator) -> None:
    """Every pixel, exactly."""
    red = s.call("fill_red", before(rng)).args["img"]
    np.testing.assert_array_equal(red, np.broadcast_to((1, 0, 0), (PIXELS, 3)))
    full = s.call("fill", before(rng), COLOR).args["img"]
    np.testing.assert_array_equal(full, painted(red, np.ones(PIXELS, bool)))


def test_horizontal_gradient(s: Session, rng: np.random.Generator) -> None:
    """From c2 at the bottom to c1 at the top, one colour a row: c1 * j / H + c2 * (1 - j / H)."""
    c1, c2 = (1, 0.25, -3), (0, 0.75, 5)
    img = s.call("horizontal_gradient", before(rng), c1, c2).args["img"].reshape(HEIGHT, WIDTH, 3)
    share = np.arange(HEIGHT)[:, None] / HEIGHT
    np.testing.assert_allclose(img[:, 0], share * c1 + (1 - share) * c2, rtol=0, atol=1e-6)
    np.testing.assert_array_equal(img, np.broadcast_to(img[:, :1], img.shape))


RECTANGLES = [
    ((10, 20), (30, 40)),
    ((30, 40), (10, 20)),
    ((30, 20), (10, 40)),
    ((10.9, 20.9), (30.1, 40.9)),
    ((0, 0), (WIDTH - 1, HEIGHT - 1)),
    ((0, 0), (WIDTH, HEIGHT)),
    ((-5, -7), (3, 2)),
    ((90, 60), (200, 100)),
    ((-10, -10), (-1, -1)),
    ((-10, 5), (200, 5)),
    ((WIDTH, 0), (WIDTH + 5, 5)),
    ((0, HEIGHT), (5, HEIGHT + 5)),
    ((7, 7), (7, 7)),
    ((-0.5, -0.9), (0, 0)),
    ((-HUGE, -HUGE), (HUGE, HUGE)),
    ((HUGE, 0), (HUGE, HUGE)),
    ((-np.inf, 0), (np.inf, 3)),
]


@pytest.mark.parametrize(("p1", "p2"), RECTANGLES)
def test_fill_rect(
    s: Session, rng: np.random.Generator, p1: tuple[float, float], p2: tuple[float, float]
) -> None:
    """Both corners included, in any order, coordinates cut to integers, clipped to the picture."""
    img = before(rng)
    got = s.call("fill_rect", img, COLOR, (*p1, 9), (*p2, -9)).args["img"]
    (left, bottom), (right, top) = np.trunc(np.sort([p1, p2], axis=0))
    mask = (left <= COLUMN) & (right >= COLUMN) & (bottom <= ROW) & (top >= ROW)
    np.testing.assert_array_equal(got, painted(img, mask))


DISCS = [
    (10, (48, 32)),
    (10.5, (48.25, 31.75)),
    (5, (0, 0)),
    (5, (WIDTH, HEIGHT)),
    (200, (48, 32)),
    (4, (-3, 70)),
    (3, (-3, 5)),
    (0.5, (7, 7)),
    (0.4, (7.5, 7.5)),
    (0, (7, 7)),
    (-5, (7, 7)),
    (5, (1e9, -1e9)),
    (5, (HUGE, 7)),
    (HUGE, (7, 7)),
    (np.nan, (7, 7)),
    (5, (np.nan, 7)),
    (5, (np.inf, 7)),
]


@pytest.mark.parametrize(("radius", "center"), DISCS)
def test_fill_circle(
    s: Session, rng: np.random.Generator, radius: float, center: tuple[float, float]
) -> None:
    """The pixels strictly nearer than the radius, none for a radius of zero or less, clipped."""
    img = before(rng)
    got = s.call("fill_circle", img, radius, (*center, 5), COLOR).args["img"]
    # Numbers that float squares without rounding, or that are far from any rim.
    with np.errstate(invalid="ignore", over="ignore"):
        mask = (radius > 0) & (np.hypot(COLUMN - center[0], ROW - center[1]) < radius)
    np.testing.assert_array_equal(got, painted(img, mask))


def test_random_rectangles_and_discs(s: Session, rng: np.random.Generator) -> None:
    """A hundred of each, in and around the picture."""
    corners = rng.uniform(-50, 150, (100, 2, 2)).astype(np.float32)
    radii = rng.uniform(0, 60, 100).astype(np.float32)
    img = before(rng)
    for (p1, p2), radius in zip(corners, radii, strict=True):
        got = s.call("fill_rect", img, COLOR, (*p1, 0), (*p2, 0)).args["img"]
        (left, bottom), (right, top) = np.trunc(np.sort([p1, p2], axis=0))
        mask = (left <= COLUMN) & (right >= COLUMN) & (bottom <= ROW) & (top >= ROW)
        np.testing.assert_array_equal(got, painted(img, mask))
        got = s.call("fill_circle", img, radius, (*p1, 0), COLOR).args["img"]
        distance = np.hypot(COLUMN - p1[0].astype(float), ROW - p1[1].astype(float))
        sure = (np.abs(distance - radius) > 1e-4).ravel()
        np.testing.assert_array_equal(got[sure], painted(img, distance < radius)[sure])


def test_draw_stays_in_its_picture(s: Session, rng: np.random.Generator) -> None:
    """The drawing covers all the picture with finite colours, whatever was there."""
    first = s.call("draw", before(rng)).args["img"]
    again = s.call("draw", np.full((PIXELS, 3), np.nan, np.float32)).args["img"]
    assert np.isfinite(first).all()
    np.testing.assert_array_equal(first, again)
    assert len(np.unique(first, axis=0)) > 100
