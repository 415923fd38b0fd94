"""The pixel of a picture, held against the rays that it is made of."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from grader.checking.expected_data import Array
from grader.evaluation.replay.case import ReplayedPixel, WrongValue, told, unlike
from grader.evaluation.replay.reflections import transparent

_STEPS = 5  # a side of a square, where its colours are taken
_SLACK = 0.02  # what these may have missed
_SHARE = 0.1  # of the spread, likewise


def pixel(case: ReplayedPixel) -> Iterator[WrongValue]:
    """Hold the pixel of the picture against the ray through its middle, or its samples."""
    if case.drawn is None or transparent(case.root):
        return
    probe = case.probe
    if probe.content.options["samples"] <= 1:
        if unlike(case.drawn, case.root.trace):
            yield WrongValue("pixel", "TP2.2", wanted=told(case.root.trace))
        return
    mean = probe.call("pixel_color", *case.pixel).result
    low, high = _range(case)
    slack = _SLACK + _SHARE * (high - low)
    if not ((mean >= low - slack) & (mean <= high + slack)).all():
        yield WrongValue("mean", "TP5.3")
    elif unlike(case.drawn, mean):
        yield WrongValue("pixel", "TP2.2", wanted=told(mean))


def _range(case: ReplayedPixel) -> tuple[Array, Array]:
    """Return the least and the most that a mean over the squares of a pixel can be.

    Whatever place a sample takes in its square, its colour lies between those found there.
    """
    probe, (i, j) = case.probe, case.pixel
    side = int(probe.content.options["samples"])
    steps = np.linspace(0, 1, side * (_STEPS - 1) + 1, dtype=np.float32)
    x, y = (each.ravel() for each in np.meshgrid(i + steps, j + steps))
    rays = probe.many("camera_ray", len(x), np.zeros(len(x), case.root.ray.dtype), x, y).args["r"]
    rays["seed"] = case.root.ray["seed"]
    colors = np.clip(probe.many("trace_ray", len(x), rays).result, 0, 1)
    colors = colors.reshape(len(steps), len(steps), 3)
    squares = np.stack(
        [
            colors[r : r + _STEPS, c : c + _STEPS].reshape(-1, 3)
            for r in range(0, side * (_STEPS - 1), _STEPS - 1)
            for c in range(0, side * (_STEPS - 1), _STEPS - 1)
        ]
    )
    return squares.min(axis=1).mean(axis=0), squares.max(axis=1).mean(axis=0)
