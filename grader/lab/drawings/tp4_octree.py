"""Drawings for the octree of TP4's notebook: boxes, and the intersection tests that they save.

Those that take `core` draw what the student's own functions answer.
"""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.patches import Circle, Rectangle
from mpl_toolkits.mplot3d.art3d import Line3DCollection  # type: ignore[import-untyped]

from grader.lab.bridge.core import Core
from grader.lab.bridge.counting import counter
from grader.lab.bridge.engine import OpenSession
from grader.lab.display.card import Shown
from grader.lab.display.picture import MAP, figure, new_figure
from grader.lab.display.plots import BLUE, GREY, LIGHT, ORANGE, digits, number, pixel_axes, sentence

Array = npt.NDArray[Any]

CROWD = 3  # the scene of 1024 spheres
LARGE_PIXELS = (48, 27)  # of the map of tests: each pixel is a call of its own
MOST_NODES, DEEPEST = 3000, 24  # read of a student's tree, which may hold a loop
COUNTS = (4, 16, 64, 256, 1024, 4096, 16384)  # spheres
PROBES = 300  # rays, for each count
EYE, SPAN = (-2.4, 0.0), 6.0  # of the slabs' ray: its origin, and how far it is drawn
BOX_EDGES = [(a, b) for a, b in product(range(8), repeat=2) if b > a and (a ^ b) in (1, 2, 4)]
Boxes = list[tuple[int, Array, int]]  # depth, corners (2, 3), objects of a leaf or -1


# ---- The idea, in two dimensions --------------------------------------------------------------


def quadtree(cuts: int = 2, leaf: int = 2) -> Shown:
    """Cut a square with discs into four, again and again; a disc stands in each box it overlaps.

    Parameters
    ----------
    cuts : int
        How often a box may be cut.
    leaf : int
        A box with that many discs, or fewer, is cut no more.
    """
    dice = np.random.default_rng(4)
    discs = np.column_stack([dice.uniform(0.08, 0.92, (14, 2)), dice.uniform(0.02, 0.06, 14)])
    drawn, axes = new_figure(1, 1, (5.2, 4.6))
    for x, y, radius in discs:
        axes.add_patch(Circle((x, y), radius, facecolor=LIGHT[1], edgecolor=GREY))
    leaves = _cut(discs, (0.0, 0.0, 1.0), cuts, leaf)
    for x, y, side, inside in leaves:
        axes.add_patch(Rectangle((x, y), side, side, fill=False, ec=BLUE, lw=1.2))
        if inside:
            axes.text(
                x + side / 2, y + side / 2, str(inside), ha="center", va="center", weight="bold"
            )
    listed, most = sum(each[3] for each in leaves), max(each[3] for each in leaves)
    values = {"leaves": len(leaves), "listed": listed, "most": most, "discs": len(discs)}
    axes.set(xlim=(-0.02, 1.02), ylim=(-0.02, 1.02), aspect="equal", xticks=[], yticks=[])
    axes.set_title(sentence("tp4.quadtree_title", **values), fontsize=10)
    return figure(drawn, sentence("tp4.quadtree_alt", cuts=cuts, **values))


def slabs(angle: int = 20, height: float = 0.0) -> Shown:
    """Show a ray and a box as two pairs of parallel lines: it meets what lies between both.

    Parameters
    ----------
    angle : int
        Between the ray and the axis x, degrees.
    height : float
        Of the ray's origin; the box goes from -1 to 1 both ways.
    """
    origin = np.array([EYE[0], height])
    direction = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    spans = [_between(*pair) for pair in zip(origin, direction, strict=True)]
    enter, leave = max(a for a, _ in spans), min(b for _, b in spans)
    drawn, (plan, line) = new_figure(2, 1, (8, 3.8))
    plan.add_patch(Rectangle((-1, -1), 2, 2, facecolor=LIGHT[1], edgecolor=GREY))
    plan.axline(origin, origin + direction, color=GREY, lw=1.5)
    for (a, b), color, low, name in zip(spans, (BLUE, ORANGE), (1, 0), "xy", strict=True):
        line.broken_barh([(a, b - a)], (low + 0.15, 0.7), color=color)
        line.text(-0.2, low + 0.5, name, ha="right", va="center")
        for t in (a, b):
            plan.plot(*(origin + t * direction), "o", color=color, mec="black")
    if meets := enter <= leave:
        line.axvspan(enter, leave, facecolor="none", edgecolor="black", hatch="//")
    title = sentence("tp4.slabs_hit" if meets else "tp4.slabs_miss", **_told(enter, leave))
    plan.set(xlim=(-2.6, 2.6), ylim=(-2.2, 2.2), aspect="equal", xlabel="x", ylabel="y")
    line.set(xlim=(0, SPAN), ylim=(0, 2), yticks=[], xlabel="t")
    drawn.suptitle(title)
    return figure(drawn, sentence("tp4.slabs_alt", angle=angle, title=title))


def _between(origin: float, direction: float) -> tuple[float, float]:
    """Return the t at which a ray passes -1 and 1 along one axis, the smaller first."""
    if abs(direction) < 1e-9:  # along the lines: between them all the way, or never
        return (0.0, SPAN) if abs(origin) <= 1 else (SPAN, 0.0)
    first, second = (-1 - origin) / direction, (1 - origin) / direction
    return min(first, second), max(first, second)


def _told(enter: float, leave: float) -> dict[str, str]:
    return {"enter": digits(enter, 3), "leave": digits(leave, 3)}


def _cut(
    discs: Array, square: tuple[float, float, float], cuts: int, leaf: int
) -> list[tuple[float, float, float, int]]:
    """Return the leaves of a square (x, y, side) as (x, y, side, number of discs)."""
    x, y, side = square
    nearest = np.clip(discs[:, :2], (x, y), (x + side, y + side))
    inside = discs[np.linalg.norm(nearest - discs[:, :2], axis=1) <= discs[:, 2]]
    if cuts == 0 or len(inside) <= leaf:
        return [(x, y, side, len(inside))]
    half = side / 2
    parts = [(x + a * half, y + b * half, half) for a, b in product((0, 1), repeat=2)]
    return [each for part in parts for each in _cut(inside, part, cuts - 1, leaf)]


# ---- The student's tree -------------------------------------------------------------------------


def _read_tree(stage: OpenSession) -> Boxes:
    """Return the boxes of the tree of the scene in use, the root first; none without a tree."""
    found: Boxes = []
    waiting = [(int(stage.session.get("scene_octree")), 0)]
    while waiting and len(found) < MOST_NODES:
        address, depth = waiting.pop(0)
        if not address or depth > DEEPEST:
            continue
        node = stage.session.peek(address, "octree_node")
        bounds = np.stack([node["bounds"]["min"], node["bounds"]["max"]]).astype(float)
        children = [int(each) for each in node["child"] if int(each)]
        found.append((depth, bounds, -1 if children else int(node["object_count"])))
        waiting += [(each, depth + 1) for each in children]
    return found


def boxes(core: Core, depth: int = 2) -> Shown:
    """Show in space the boxes of the student's octree of scene 3, as deep as that."""
    core.scene(CROWD)
    tree = core.engine.run(core.size, "octree_build", _read_tree)
    shown = [each for each in tree if each[0] == depth or (each[0] < depth and each[2] >= 0)]
    drawn, axes = new_figure(1, 1, (6.4, 5.2), subplot_kw={"projection": "3d"})
    centers = np.asarray(core.scene().objects.data["center"])
    axes.scatter(*_turned(centers).T, s=4, color=GREY, depthshade=False)
    for _, bounds, inside in shown:
        _edges(axes, bounds, ORANGE if inside >= 0 else BLUE)
    axes.set(xlabel="x", ylabel="-z", zlabel="y")
    if tree:
        leaves = [each[2] for each in tree if each[2] >= 0]
        values = {"boxes": len(shown), "deepest": max(each[0] for each in tree)}
        values |= {"leaves": len(leaves), "most": max(leaves, default=0)}
        title = sentence("tp4.boxes_title", **values)
    else:
        title = sentence("tp4.no_tree")
    axes.set_title(title, fontsize=10)
    return figure(drawn, sentence("tp4.boxes_alt", depth=depth, title=title))


def _turned(points: Array) -> Array:
    """Return points for matplotlib, whose vertical axis is the third one."""
    return np.stack([points[..., 0], -points[..., 2], points[..., 1]], axis=-1)


def _edges(axes: Any, bounds: Array, color: str) -> None:
    corners = _turned(np.array(list(product(*bounds.T))))
    axes.add_collection3d(Line3DCollection(corners[np.array(BOX_EDGES)], colors=color, lw=0.8))


# ---- Counting -----------------------------------------------------------------------------------


def tests_map(core: Core) -> Shown:
    """Map the tests of each ray of scene 3, without the octree and with it."""
    columns, rows = LARGE_PIXELS
    x, y = np.meshgrid(np.arange(columns) + 0.5, np.arange(rows) + 0.5)
    objects = core.scene(CROWD).objects.data
    rays = core.camera_ray(x * core.size[0] / columns, y * core.size[1] / rows).data
    counts = []
    with counter(core) as counting:
        for octree in (False, True):
            counting.place(objects, octree)
            counts.append(counting.each(rays))
    drawn, axes = new_figure(1, 2, (7, 7.4))
    told = []
    for each, tests, key in zip(axes, counts, ("tp4.list", "tp4.octree"), strict=True):
        _draw_tests(each, tests, len(objects))
        told.append(sentence(key, mean=number(float(tests.mean()), 0), most=number(tests.max(), 0)))
        each.set_title(told[-1])
    return figure(drawn, sentence("tp4.tests_alt", told=" ; ".join(told)))


def _draw_tests(axes: Axes, tests: Array, most: int) -> None:
    """Draw a map of counts, from 1 to `most` on a logarithmic scale."""
    scale = LogNorm(1, most)
    drawn = axes.imshow(
        np.maximum(tests, 1), cmap=MAP, norm=scale, origin="lower", interpolation="none"
    )
    axes.figure.colorbar(drawn, ax=axes, label=sentence("tp4.tests"), shrink=0.8)
    pixel_axes(axes, *LARGE_PIXELS)


def tests_curve(core: Core) -> Shown:
    """Draw the tests of a ray against the number of spheres, without the octree and with it."""
    dice = np.random.default_rng(7)
    start = dice.normal(size=(PROBES, 3))
    start *= 3 / np.linalg.norm(start, axis=1, keepdims=True)
    rays = core.ray(start, dice.uniform(-0.5, 0.5, (PROBES, 3)) - start).data
    model = np.array(core.sphere((0, 0, 0), 1).data)
    means: dict[bool, list[float]] = {False: [], True: []}
    with counter(core) as counting:
        for count in COUNTS:
            objects = np.repeat(model, count)
            objects["center"] = dice.uniform(-1, 1, (count, 3))
            objects["radius"] = 0.5 * count ** (-1 / 3)  # as full, whatever their number
            for octree, found in means.items():
                counting.place(objects, octree)
                found.append(counting.total(rays) / PROBES)
    drawn, axes = new_figure(1, 1, (6.8, 4.2))
    for (octree, found), color, style in zip(
        means.items(), (GREY, BLUE), ("s--", "o-"), strict=True
    ):
        label = sentence("tp4.with_tree" if octree else "tp4.without_tree")
        axes.loglog(COUNTS, np.maximum(found, 0.1), style, color=color, label=label)
    _count_axis(axes)
    told = [" ; ".join(digits(each, 3) for each in found) for found in means.values()]
    return figure(drawn, sentence("tp4.curve_alt", without=told[0], tree=told[1]))


def _count_axis(axes: Axes) -> None:
    axes.set_xticks(COUNTS, [number(each, 0) for each in COUNTS], fontsize=8)
    axes.set_xticks([], minor=True)
    axes.set(xlabel=sentence("tp4.spheres"), ylabel=sentence("tp4.tests"))
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
