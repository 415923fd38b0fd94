"""The scene in space: its objects as outlines, the rays of a pixel, and a projection to draw them.

The projection is parallel, so that a sphere is a circle whatever the side it is seen from.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from grader.evaluation.replay.probe import unit
from grader.evaluation.replay.ray_tree import SKY, Node
from grader.intake.header_numbers import header_number
from grader.lab.display.card import Shown
from grader.lab.display.picture import draw, figure, new_figure
from grader.lab.display.plots import ON_BRIGHT, ON_DARK
from grader.lab.display.vectors import Array
from grader.lab.display.words import say
from grader.lab.inspector.looking import InspectedScene, Seen

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST = 250  # objects drawn; of more, those that stand nearest to the rays
FAR = 1.6  # length of a ray that goes on, in scene units
PATCH = 3.0  # half the side of a plane's patch, scene units
_GRID = 6  # lines of a patch
_TURN = 24  # corners of a circle
SIDE = 0.6  # radians from the camera's own direction, at the start
TILT = 0.35
# Colours that stay apart for colour-blind readers, by kind of ray.
COLORS = {
    "camera": "#000000",
    "mirror": "#d55e00",
    "refracted": "#cc79a7",
    "light": "#b8860b",
    "hidden": "#6b6b6b",
}


@dataclass(frozen=True)
class Segment:
    """A piece of a ray, from a point to another; `row` is that of the table."""

    row: str
    kind: str
    start: Array
    end: Array


def segments(inspected: InspectedScene, root: Node) -> list[Segment]:
    """Return the rays of a pixel as segments."""
    made: list[Segment] = []
    for depth, node in enumerate(root.walk()):
        start, direction = node.ray["orig"], unit(node.ray["dir"])
        end = start + FAR * direction
        if node.hit is not None:
            end = node.hit.position
        made.append(Segment(str(depth), node.kind.value, start, end))
        lights = inspected.probe.content.lights["position"]
        for lit in node.lights:
            whole = float(np.linalg.norm(lights[lit.index] - end))
            kind = "light" if lit.counts else "hidden"
            to = end + min(whole, FAR) * lit.toward
            made.append(Segment(f"{depth}.{lit.index}", kind, end, to))
    return [each for each in made if np.isfinite([*each.start, *each.end]).all()]


def circles(objects: Array, near: Array) -> tuple[Array, Array]:
    """Return the spheres to be drawn, (count, 4): centre and radius; and their indices."""
    which = np.flatnonzero(objects["type"] == header_number("SPHERE"))
    if len(which) > MOST:
        away = np.linalg.norm(objects["center"][which] - near, axis=1)
        which = which[np.argsort(away)[:MOST]]
    spheres = np.column_stack([objects["center"][which], objects["radius"][which]])
    return spheres, which


def wires(objects: Array, near: Array) -> list[tuple[int, Array]]:
    """Return the other objects as polylines, with their indices."""
    made: list[tuple[int, Array]] = []
    for index in np.flatnonzero(objects["type"] != header_number("SPHERE"))[:MOST]:
        each = objects[index]
        lines = _patch(each, near) if each["type"] == header_number("PLANE") else _sides(each)
        made += [(int(index), line) for line in lines]
    return made


def _patch(plane: Any, near: Array) -> list[Array]:
    """Return a grid on a plane, around the point of it that is nearest to `near`."""
    normal = plane["normal"]
    middle = near - (near @ normal + plane["dist"]) * normal
    u, v = across(normal)
    steps = np.linspace(-PATCH, PATCH, _GRID + 1)
    ends = np.array([-PATCH, PATCH])
    lines = [middle + s * u + ends[:, None] * v for s in steps]
    return lines + [middle + s * v + ends[:, None] * u for s in steps]


def _sides(each: Any) -> list[Array]:
    """Return the discs of a cylinder or a cone, and lines along its side."""
    u, v = across(each["axis"])
    angles = np.linspace(0, 2 * np.pi, _TURN + 1)[:, None]
    rim = each["radius"] * (np.cos(angles) * u + np.sin(angles) * v)
    bottom, top = each["base"] + rim, each["base"] + each["length"] * each["axis"]
    is_cylinder = each["type"] == header_number("CYLINDER")
    upper = top + rim if is_cylinder else np.broadcast_to(top, rim.shape)
    lines = [np.stack([bottom[k], upper[k]]) for k in range(0, _TURN, _TURN // 6)]
    return [bottom, *lines, *([upper] if is_cylinder else [])]


def across(axis: Array) -> tuple[Array, Array]:
    """Return two unit vectors across a unit axis, and across each other."""
    other = np.eye(3, dtype=np.float32)[int(np.argmin(np.abs(axis)))]
    u = unit(np.cross(axis, other))
    return u, np.cross(axis, u)


def start_view(inspected: InspectedScene) -> tuple[float, float]:
    """Return yaw and pitch at the start, radians: from the camera's side, a little above."""
    zdir = inspected.probe.content.camera["zdir"]
    return float(np.arctan2(-zdir[0], -zdir[2])) + SIDE, TILT


def project(points: Array, yaw: float, pitch: float) -> Array:
    """Return points, shape (..., 3), as they are seen from a direction: right and up, (..., 2)."""
    right = np.array([np.cos(yaw), 0, -np.sin(yaw)])
    up = np.array([-np.sin(pitch) * np.sin(yaw), np.cos(pitch), -np.sin(pitch) * np.cos(yaw)])
    return np.stack([points @ right, points @ up], axis=-1)


def middle(found: list[Segment]) -> Array:
    """Return the point that the view turns about: the first hit."""
    return found[0].end if found else np.zeros(3, np.float32)


def color_of(objects: Array, index: int) -> str:
    """Return the diffuse colour of an object, as HTML writes it."""
    if index == SKY:
        return "#333399"
    kd = np.clip(np.nan_to_num(objects["mat"]["kd"][index]) * 255, 0, 255).astype(int)
    return f"#{kd[0]:02x}{kd[1]:02x}{kd[2]:02x}"


# ---- The static picture -----------------------------------------------------------------------


def static(inspected: InspectedScene, seen: Seen) -> Shown:
    """Return the picture with the pixel circled, and the rays in the scene beside it."""
    drawn, axes = new_figure(2, 1, inches=(10.5, 3.6), width_ratios=(3, 2))
    i, j = seen.pixel
    draw(axes[0], inspected.picture, say("inspect.picture_title", i=i, j=j))
    for color, size in ((ON_DARK, 13), (ON_BRIGHT, 16)):
        axes[0].plot(i, j, "o", markersize=size, markerfacecolor="none", markeredgecolor=color)
    if seen.case is not None:
        _draw_space(axes[1], inspected, segments(inspected, seen.case.root))
    axes[1].set_axis_off()
    return figure(drawn, say("inspect.alt", i=i, j=j))


def _draw_space(axes: Axes, inspected: InspectedScene, found: list[Segment]) -> None:
    from matplotlib.patches import Circle

    objects, around = inspected.probe.content.objects, middle(found)
    yaw, pitch = start_view(inspected)
    for _, line in wires(objects, around):
        x, y = project(line, yaw, pitch).T
        axes.plot(x, y, color="0.75", linewidth=0.6, zorder=1)
    spheres, which = circles(objects, around)
    for sphere, index in zip(spheres, which, strict=True):
        x, y = project(sphere[:3], yaw, pitch)
        face = color_of(objects, int(index))
        axes.add_patch(Circle((x, y), sphere[3], facecolor=face, edgecolor="0.3", alpha=0.55))
    for each in found:
        x, y = project(np.stack([each.start, each.end]), yaw, pitch).T
        style = "--" if each.kind == "hidden" else "-"
        axes.plot(x, y, style, color=COLORS[each.kind], linewidth=1.6, zorder=3)
    axes.set_aspect("equal")
    axes.set_title(say("inspect.scene_title"))
