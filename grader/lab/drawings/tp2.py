"""Drawings for TP2's notebook: the camera's rays, where they meet planes, spheres and cylinders.

Those that take `core` draw what the student's own functions answer.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Rectangle

from grader.lab.bridge.core import Core
from grader.lab.display.card import Shown
from grader.lab.display.picture import draw, figure, new_figure, show
from grader.lab.display.plots import BLUE, GREEN, GREY, LIGHT, ORANGE, RED, cross, number, sentence
from grader.lab.display.values import Hit, Ray

Array = npt.NDArray[Any]

SKY = (0.2, 0.2, 0.6)
COARSE = (160, 90)  # pixels: enough for maps that need many calls
ALONG = 1e-6  # a sine or cosine below is that of a ray along the axis, or straight across it
NEAR, FAR = 2.0, 8.0  # the distances between which a depth map tells apart, lengths of dir


# ---- The camera ------------------------------------------------------------------------------


def pyramid(core: Core, i: int = 0, j: int = 0) -> Shown:
    """Show the camera's pyramid with 16 x 9 large pixels, and the ray of pixel (i, j).

    The pyramid comes from the camera's vectors, the ray from the student's camera_ray.
    """
    camera = core.scene(0).camera
    eye = np.asarray(camera.position)
    axes_of = {name: np.asarray(getattr(camera, name)) for name in ("xdir", "ydir", "zdir")}
    up = axes_of["ydir"] / camera.aspect
    middle = eye + np.asarray(camera.center)
    corners = [middle + x * axes_of["xdir"] + y * up for x, y in SQUARE]
    wanted = middle + ((i + 0.5) / 8 - 1) * axes_of["xdir"] + ((j + 0.5) / 4.5 - 1) * up
    drawn, axes = new_figure(
        1, 1, (7, 5), subplot_kw={"projection": "3d", "computed_zorder": False}
    )
    _lines(axes, [*corners, corners[0]], BLUE)
    for k in range(17):
        _lines(axes, [_between(corners, k / 16, y) for y in (0, 1)], GREY, lw=0.4)
    for k in range(10):
        _lines(axes, [_between(corners, x, k / 9) for x in (0, 1)], GREY, lw=0.4)
    for corner in corners:
        _lines(axes, [eye, corner], BLUE, lw=0.8)
    for (name, axis), color in zip(axes_of.items(), (RED, GREEN, BLUE), strict=True):
        _lines(axes, [eye, eye + 0.6 * axis], color, lw=2.5)
        axes.text(*_turned(eye + 0.72 * axis), name)
    axes.scatter(*_turned(wanted), color=ORANGE, s=50, edgecolors="black", zorder=5)
    width, height = core.size
    ray = core.camera_ray((i + 0.5) * width / 16, (j + 0.5) * height / 9)
    start = np.asarray(ray.orig)
    _lines(axes, [start, start + 2.3 * np.asarray(ray.dir)], "black", lw=2, ls="--")
    axes.text(*_turned(corners[0] - 0.12 * up), "(0, 0)", ha="center", va="top")
    axes.set_title(f"(i, j) = ({i}, {j})")
    sides = (axes.get_xlim(), axes.get_ylim(), axes.get_zlim())
    axes.set_box_aspect([float(np.ptp(each)) for each in sides], zoom=1.5)
    axes.set_axis_off()
    axes.view_init(elev=12, azim=100)
    return figure(drawn, sentence("tp2.pyramid_alt", i=i, j=j))


SQUARE = ((-1, -1), (1, -1), (1, 1), (-1, 1))  # corners of the image plane, along xdir and ydir


def _between(corners: list[Array], x: float, y: float) -> Array:
    """Return the point of the image plane at shares x and y of its sides, from corner (0, 0)."""
    place: Array = corners[0] + x * (corners[1] - corners[0]) + y * (corners[3] - corners[0])
    return place


def _turned(point: Array) -> Array:
    """Return a point for matplotlib, whose vertical axis is the third one."""
    x, y, z = point
    return np.array([x, -z, y])


def _lines(axes: Any, points: list[Array], color: str, **style: Any) -> None:
    axes.plot(*np.transpose([_turned(each) for each in points]), color=color, **style)


def directions(core: Core) -> Shown:
    """Draw figure 3: where each ray crosses the image plane, as red and green."""
    camera = core.scene(0).camera
    rays = np.asarray(_rays(core).dir)
    ahead = rays @ np.asarray(camera.zdir)
    half = np.tan(np.radians(camera.fov) / 2)
    picture = np.zeros((*rays.shape[:2], 3))
    with np.errstate(all="ignore"):
        picture[..., 0] = rays @ np.asarray(camera.xdir) / ahead / half * 0.5 + 0.5
        picture[..., 1] = rays @ np.asarray(camera.ydir) / ahead / half * camera.aspect * 0.5 + 0.5
    return show(picture, "figure 3", alt=sentence("tp2.directions_alt", corner=_corner(picture)))


def _corner(picture: Array) -> str:
    """Return the name of the darkest corner, or of none when all are alike."""
    corners = {
        "bottom_left": (0, 0),
        "bottom_right": (0, -1),
        "top_left": (-1, 0),
        "top_right": (-1, -1),
    }
    sums = {name: float(picture[place].sum()) for name, place in corners.items()}
    alike = max(sums.values()) - min(sums.values()) < 0.1
    return sentence("tp2.none" if alike else f"tp2.{min(sums, key=lambda name: sums[name])}")


def dot_product(core: Core) -> Shown:
    """Draw a map of the dot product of each ray's direction and the camera's zdir."""
    rays = np.asarray(_rays(core).dir)
    values = rays @ np.asarray(core.scene(0).camera.zdir)
    corner = np.asarray(core.camera_ray(0.5, 0.5).dir) @ np.asarray(core.scene(0).camera.zdir)
    told = [number(float(each), 2) for each in (values[values.shape[0] // 2].max(), corner)]
    drawn, axes = new_figure(1, 1, (7, 4))
    title = sentence("tp2.dot_title", middle=told[0], corner=told[1])
    draw(axes, values, title, label="d . zdir", limits=(0, max(1.0, float(values.max()))))
    return figure(drawn, title)


def _rays(core: Core) -> Ray:
    """Return the student's rays through the middles of 160 x 90 large pixels, bottom row first."""
    (width, height), (columns, rows) = core.size, COARSE
    x, y = np.meshgrid(np.arange(columns) + 0.5, np.arange(rows) + 0.5)
    rays: Ray = core.camera_ray(x * width / columns, y * height / rows)
    return rays


# ---- Where a ray meets something ----------------------------------------------------------------


def ray_points(t: float = 1.0, length: float = 2.0) -> Shown:
    """Show the point r(t) of a ray that leaves 0 along z, with a direction of that length."""
    drawn, axes = new_figure(1, 1, (7.5, 2.2))
    axes.plot([-4, 8.4], [0, 0], color=GREY, lw=1)
    axes.annotate("", (length, 0), (0, 0), arrowprops={"arrowstyle": "->", "color": BLUE, "lw": 3})
    axes.text(length / 2, -0.32, "d", ha="center")
    for step in range(-1, 5):
        axes.plot(step * length, 0, "|", color="black", ms=12)
        axes.text(step * length, 0.24, f"t={step}", ha="center", fontsize=8)
    axes.axvline(6, color=RED, lw=4)
    axes.plot(t * length, 0, "o", color=ORANGE, mec="black", ms=10)
    axes.set(xlim=(-4.2, 8.4), ylim=(-0.6, 0.6), yticks=[], xlabel="z")
    axes.set_title(
        f"r({number(t, 2)}) = {number(t, 2)} × {number(length, 1)} = {number(t * length, 2)}"
    )
    return figure(drawn, sentence("tp2.points_alt", t=number(t, 2), z=number(t * length, 2)))


def plane_meeting(angle: int = -20) -> Shown:
    """Show, from the side, a ray that leaves at an angle (degrees, up) and the floor of scene 0."""
    eye, floor = np.array([0.0, 0.8]), -0.2
    direction = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    drawn, axes = new_figure(1, 1, (7, 3.4))
    axes.axhspan(-1, floor, color=LIGHT[1], hatch="//", ec=GREY)
    axes.annotate("", (-2.5, floor + 0.7), (-2.5, floor), arrowprops={"arrowstyle": "->", "lw": 2})
    axes.text(-2.7, floor + 0.3, "n")
    axes.plot(*np.transpose([eye, eye + 9 * direction]), color=BLUE, lw=2)
    axes.plot(*np.transpose([eye, eye - 9 * direction]), color=BLUE, ls=":", lw=1)
    axes.plot(*eye, "o", color="black")
    if angle == 0:
        title = sentence("tp2.parallel")
    else:
        t = (floor - eye[1]) / direction[1]
        axes.plot(*(eye + t * direction), "o", color=ORANGE, mec="black", ms=9)
        key = "tp2.in_front" if t >= 0 else "tp2.behind"
        title = sentence(key, t=number(t, 2), slope=number(direction[1], 2))
    axes.set(xlim=(-4, 4.5), ylim=(-0.7, 2.2), xlabel="x", ylabel="y", aspect="equal", title=title)
    return figure(drawn, sentence("tp2.plane_alt", angle=angle, title=title))


def sphere_curve(height: float = 0.5, start: float = -3.0) -> Shown:
    """Show a ray that passes a ball of radius 1, and f(t), which is zero on the sphere.

    Parameters
    ----------
    height, start : float
        The ray leaves (start, height) towards growing x; the ball's centre is (0, 0).
    """
    t = np.linspace(-3, 7, 2001)
    f = (start + t) ** 2 + height**2 - 1
    roots = t[:-1][np.sign(f[:-1]) != np.sign(f[1:])]
    ahead = [root for root in roots if root >= 0]
    drawn, (scene, curve) = new_figure(2, 1, (8.5, 3.6))
    scene.add_patch(Circle((0, 0), 1, facecolor=LIGHT[1], edgecolor=GREY))
    scene.plot([start, 5], [height, height], color=BLUE, lw=2)
    scene.plot([-4, start], [height, height], color=BLUE, ls=":", lw=1)
    scene.plot(start, height, "o", color="black")
    scene.set(xlim=(-4, 4), ylim=(-2, 2), aspect="equal", xlabel="x", ylabel="y")
    curve.axhline(0, color=GREY, lw=1)
    curve.axvspan(-3, 0, color=LIGHT[1])
    curve.plot(t, f, color=BLUE)
    curve.set(xlim=(-3, 7), ylim=(-2, 10), xlabel="t", ylabel="f(t)")
    for root in roots:
        color = ORANGE if ahead and root == ahead[0] else "white"
        scene.plot(start + root, height, "o", color=color, mec="black", ms=9)
        curve.plot(root, 0, "o", color=color, mec="black", ms=9)
    found = number(float(ahead[0]), 2) if ahead else sentence("tp2.no_root")
    curve.set_title(sentence("tp2.roots", count=len(roots), found=found))
    return figure(drawn, sentence("tp2.sphere_alt", count=len(roots), found=found))


# ---- The scene ----------------------------------------------------------------------------------


def _met(core: Core, rays: Ray) -> list[Hit]:
    """Return what the student's functions find for each object of the scene, taken alone."""
    return [core.intersect_object(rays, each) for each in core.scene().objects]


def last_object_wins(core: Core) -> Shown:
    """Draw scene 0 as it would look if no hit lowered tmax: each object over those before it."""
    core.scene(0)
    picture = np.full((COARSE[1], COARSE[0], 3), SKY, np.float32)
    found = _met(core, _rays(core))
    for hits in found:
        picture[hits.hit] = hits.material.data["kd"][hits.hit]
    floor, met = np.mean(found[-1].hit), np.mean(np.any([each.hit for each in found], axis=0))
    shares = zip(("floor", "balls", "sky"), (floor, met - floor, 1 - met), strict=True)
    told = {key: number(100 * float(each), 0) for key, each in shares}
    return show(picture, alt=sentence("tp2.last_alt", **told))


def depth_and_normals(core: Core) -> Shown:
    """Draw two maps of scene 0: the t of the nearest hit, and its normal as a colour."""
    core.scene(0)
    hits = core.intersect_scene(_rays(core))
    normals = np.full((*hits.shape, 3), SKY, np.float32)
    normals[hits.hit] = hits.normal[hits.hit] * 0.5 + 0.5
    drawn, (depth, colored) = new_figure(1, 2, (7, 7.4))
    draw(depth, hits.t, sentence("tp2.depth"), label="t", limits=(NEAR, FAR))
    draw(colored, normals, sentence("tp2.normals"))
    share = number(100 * float(np.mean(hits.hit)), 0)
    return figure(drawn, sentence("tp2.maps_alt", share=share))


def probe(core: Core, i: int = 320, j: int = 160) -> Shown:
    """Show what the ray of a pixel of scene 0 meets: each object alone, at its t."""
    picture = core.render(scene=0, shading=False)
    objects = core.scene().objects
    hits = _met(core, core.camera_ray(i + 0.5, j + 0.5))
    drawn, (seen, line) = new_figure(2, 1, (9, 3.4), width_ratios=(1.4, 1))
    draw(seen, picture, f"(i, j) = ({i}, {j})")
    cross(seen, i, j)
    for k, (each, hit) in enumerate(zip(objects, hits, strict=True)):
        line.axhline(k, color=GREY, lw=0.6)
        if hit:
            line.plot(hit.t, k, "o", color=tuple(np.asarray(each.mat.kd)), mec="black", ms=10)
    ends = [hit.t for hit in hits if hit]
    line.set(yticks=range(len(objects)), yticklabels=[f"scene[{k}]" for k in range(len(objects))])
    line.set(xlim=(0, max([FAR, *ends]) * 1.05), xlabel="t")
    line.invert_yaxis()
    found = sentence("tp2.first", t=number(min(ends), 2)) if ends else sentence("tp2.only_sky")
    line.set_title(found)
    return figure(drawn, sentence("tp2.probe_alt", i=i, j=j, count=len(ends), found=found))


def cylinder_section(tilt: int = 30) -> Shown:
    """Show a cylinder of radius 1 and length 2 cut along a ray, and seen along its axis.

    Parameters
    ----------
    tilt : int
        Angle between the ray and the axis, degrees.
    """
    across, along = np.sin(np.radians(tilt)), np.cos(np.radians(tilt))
    offset, top = 0.5, 0.4  # where the ray passes: its distance to the axis, its height there
    half = float(np.sqrt(1 - offset**2))
    drawn, (side, end) = new_figure(2, 1, (8, 3.8))
    side.add_patch(Rectangle((-half, -1), 2 * half, 2, facecolor=LIGHT[1], edgecolor=GREY))
    end.add_patch(Circle((0, 0), 1, facecolor=LIGHT[1], edgecolor=GREY))
    t = np.array([-4.0, 4.0])
    side.plot(t * across, top - t * along, color=BLUE, lw=2)
    end.plot(t * across, [offset, offset], color=BLUE, lw=2)
    if across < ALONG:
        end.plot(0, offset, "o", color=BLUE)
    by_side = half / max(across, ALONG)  # the t of the side, before (-) and after
    by_discs = ((top - 1) / max(along, ALONG), (top + 1) / max(along, ALONG))
    for t_met in (max(-by_side, by_discs[0]), min(by_side, by_discs[1])):
        side.plot(t_met * across, top - t_met * along, "o", color=ORANGE, mec="black", ms=9)
    entry = sentence("tp2.side" if -by_side > by_discs[0] else "tp2.upper")
    leave = sentence("tp2.side" if by_side < by_discs[1] else "tp2.lower")
    _square(side, sentence("tp2.cut"), "z")
    _square(end, sentence("tp2.along_axis"), "x")
    drawn.suptitle(sentence("tp2.enters", tilt=tilt, entry=entry, leave=leave))
    return figure(drawn, sentence("tp2.cylinder_alt", tilt=tilt, entry=entry, leave=leave))


def _square(axes: Axes, title: str, vertical: str) -> None:
    axes.set(xlim=(-2.2, 2.2), ylim=(-2.2, 2.2), aspect="equal", title=title)
    axes.set(xlabel="y", ylabel=vertical)
