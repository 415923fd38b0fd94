"""The first value of a replayed pixel that goes wrong, and the exercise it belongs to.

Values are taken in the order in which the ray's colour is made. Each is compared with the maps of
the reference where there are any, or else with what the values before it lead to: so the first
that differs is the one to look at.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from grader.evaluation.replay.case import ReplayedPixel, WrongValue, told, unlike
from grader.evaluation.replay.intersections import camera, meeting, surface
from grader.evaluation.replay.lighting import lights
from grader.evaluation.replay.ray_tree import Node
from grader.evaluation.replay.reflections import bounce
from grader.evaluation.replay.sampling import pixel

_SWITCHES = ("shading", "shadows", "reflections", "fresnel", "refraction")

_Check = Callable[[ReplayedPixel, Node, int], Iterator[WrongValue]]


def first(case: ReplayedPixel) -> WrongValue | None:
    """Return the first value that goes wrong; None when each follows from the one before."""
    return next(_faults(case), None)


def differs_from_own(case: ReplayedPixel) -> bool:
    """Return whether trace_ray gives something else than the parts that were replayed."""
    return unlike(case.root.trace, case.root.total)


def _faults(case: ReplayedPixel) -> Iterator[WrongValue]:
    yield from camera(case)
    for depth, node in enumerate(case.root.walk()):
        for check in _CHECKS:
            yield from check(case, node, depth)
    yield from pixel(case)


def _whole(case: ReplayedPixel, node: Node, depth: int) -> Iterator[WrongValue]:
    """Hold trace_ray against the sum of its parts; who uses none of them is told that first."""
    if unlike(node.trace, node.total) and not _with_all_features(case, node):
        yield WrongValue("trace", "TP2.6", depth, wanted=told(node.total))


def _with_all_features(case: ReplayedPixel, node: Node) -> bool:
    """Return whether trace_ray gives what its parts add up to with all the options on."""
    if node.hit is None:
        return False
    with case.probe.instead(**dict.fromkeys(_SWITCHES, True)):
        total = case.probe.total(node.ray, node.hit)
    return not unlike(node.trace, total)


_CHECKS: tuple[_Check, ...] = (meeting, surface, _whole, lights, bounce)
