"""The first value of a replayed pixel that goes wrong, and the exercise it belongs to.

Values are taken in the order in which the ray's colour is made. Each is compared with the maps of
the reference where there are any, or else with what the values before it lead to: so the first
that differs is the one to look at.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from grader.lab.inspector.case import Case, Fault, far, outside, told
from grader.lab.inspector.lighting import bounce, lights, whole
from grader.lab.inspector.meeting import camera, meeting, surface
from grader.lab.inspector.nodes import Node

_Check = Callable[[Case, Node, int], Iterator[Fault]]
_CHECKS: tuple[_Check, ...] = (meeting, surface, lights, bounce, whole)


def first(case: Case) -> Fault | None:
    """Return the first value that goes wrong; None when each follows from the one before."""
    return next(_faults(case), None)


def differs_from_own(case: Case) -> bool:
    """Return whether trace_ray gives something else than the parts that were replayed."""
    return far(case.root.trace, case.root.total)


def _faults(case: Case) -> Iterator[Fault]:
    yield from camera(case)
    for depth, node in enumerate(case.root.walk()):
        for check in _CHECKS:
            yield from check(case, node, depth)
        if depth == 0:
            yield from _pixel(case)


def _pixel(case: Case) -> Iterator[Fault]:
    """Hold the pixel of the picture against the ray through its middle."""
    if case.drawn is None or _has_glass(case.root):
        return
    probe, (i, j) = case.probe, case.pixel
    if probe.samples == 1:
        if far(case.drawn, case.root.trace):
            yield Fault("pixel", "TP2.2", wanted=told(case.root.trace))
        return
    mean = np.asarray(probe.call("pixel_color", i, j))
    if far(case.drawn, mean):
        yield Fault("pixel", "TP2.2", wanted=told(mean))
    steps = np.linspace(0, 1, 2 * probe.samples + 1)
    x, y = (each.ravel() for each in np.meshgrid(i + steps, j + steps))
    rays = probe.call("camera_ray", x, y)
    colors = np.clip(np.asarray(probe.call("trace_ray", rays)), 0, 1)
    if outside(mean, colors.min(axis=0)[None], colors.max(axis=0)[None]):
        yield Fault("mean", "TP5.3")


def _has_glass(root: Node) -> bool:
    return any(
        node.hit is not None and node.met and node.hit.material.refraction_index > 0
        for node in root.walk()
    )
