"""Drawings for TP4's notebook: shadow rays, rounding, mirrors and how often a ray bounces.

Those that take `core` draw what the student's own functions answer.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.patches import Circle
from matplotlib.ticker import MaxNLocator

from grader.intake.header_numbers import header_number
from grader.lab.bridge.core import Core
from grader.lab.bridge.scene import Scene
from grader.lab.display.card import Shown
from grader.lab.display.picture import Picture, draw, figure, new_figure, show
from grader.lab.display.plots import BLUE, GREY, LIGHT, ORANGE, RED, cross, digits, number, sentence
from grader.lab.display.values import Hit, Ray

Array = npt.NDArray[Any]

FLOOR = -0.2  # height of the floor of the scenes
COARSE = (160, 90)  # pixels: enough for maps that need many calls
POINT = np.dtype([("position", "f4", (3,)), ("normal", "f4", (3,))])  # of an intersection
LAMP, BARRIER, BEYOND = (0.6, 1.5), (0.1, 0.5, 0.3), (1.55, 2.2, 0.4)  # x, y, radius
DARK = 1e-3  # of a component: less is none
NANO = 1e-9  # the unit of surface_errors
HIGH = 0.5  # a ball above it hides no path: only its outline is drawn, seen from above
FAR = 6.0  # how much of a ray that meets nothing is drawn
SHOWN_GENERATIONS = 6  # of rays, in a tree that can still be read


def _rays(core: Core, size: tuple[int, int] = COARSE) -> Ray:
    """Return the student's rays through the middles of large pixels, bottom row first."""
    x, y = np.meshgrid(np.arange(size[0]) + 0.5, np.arange(size[1]) + 0.5)
    rays: Ray = core.camera_ray(x * core.size[0] / size[0], y * core.size[1] / size[1])
    return rays


# ---- Shadows ------------------------------------------------------------------------------------


def shadow_ray(core: Core, x: float = -0.4) -> Shown:
    """Show, from the side, a point of the floor and the way to the light: what in_shadow says.

    A ball may stand in the way; another one stands beyond the light.
    """
    balls = [core.sphere((a, b, 0), radius) for a, b, radius in (BARRIER, BEYOND)]
    lamp = core.light((*LAMP, 0))
    core.scene(0)
    core.set_scene([*balls, core.plane((0, 1, 0), -FLOOR)], lamp)
    point = np.zeros((), POINT)
    point["position"], point["normal"] = (x, FLOOR, 0), (0, 1, 0)
    barred = bool(core.in_shadow(point, lamp))
    drawn, axes = new_figure(1, 1, (7, 4.2))
    axes.axhspan(-0.6, FLOOR, color=LIGHT[1], hatch="//", ec=GREY)
    for a, b, radius in (BARRIER, BEYOND):
        axes.add_patch(Circle((a, b), radius, facecolor=LIGHT[1], edgecolor=GREY))
    style = (GREY, "--") if barred else (ORANGE, "-")
    axes.plot([x, LAMP[0]], [FLOOR, LAMP[1]], color=style[0], ls=style[1], lw=2)
    axes.plot(x, FLOOR, "o", color="black")
    axes.plot(*LAMP, "*", color=ORANGE, mec="black", ms=18)
    axes.set(xlim=(-3.2, 2.8), ylim=(-0.6, 2.8), aspect="equal", xlabel="x", ylabel="y")
    told = sentence("tp4.barred" if barred else "tp4.free")
    axes.set_title(sentence("tp4.shadow_title", answer=told))
    return figure(drawn, sentence("tp4.ray_alt", x=number(x, 2), answer=told))


def _reached(core: Core, hits: Hit) -> Array:
    """Return how many lights in_shadow lets through to each point hit; NaN where none is."""
    reached = np.full(hits.shape, np.nan)
    reached[hits.hit] = 0
    if hits.hit.any():
        for each in core.scene().lights:
            reached[hits.hit] += ~np.asarray(core.in_shadow(hits[hits.hit], each), bool)
    return reached


def lights_reaching(core: Core, scene: int = 4) -> Shown:
    """Map how many lights reach the point that each pixel shows, beside the picture."""
    lights = len(core.scene(scene).lights)
    reached = _reached(core, core.intersect_scene(_rays(core)))
    picture = core.render(scene, reflections=False)
    drawn, (seen, counted) = new_figure(1, 2, (7, 7.4))
    draw(seen, picture, sentence("tp4.scene", scene=scene))
    title = sentence("tp4.lights_title")
    draw(counted, reached, title, label=sentence("tp4.lights"), limits=(0, max(lights, 1)))
    drawn.axes[-1].yaxis.set_major_locator(MaxNLocator(integer=True))  # of the scale of colours
    shares = [number(100 * float(np.mean(reached == k)), 0) for k in range(lights + 1)]
    return figure(drawn, sentence("tp4.lights_alt", scene=scene, shares=" ; ".join(shares)))


def colored_shadows(core: Core) -> Shown:
    """Draw a white ball on a white floor, lit by a red, a green and a blue light."""
    white = {"kd": (0.9, 0.9, 0.9), "shininess": 20.0}
    places = ((-1.2, 2.2, 1.5), (0.2, 2.4, 2.2), (1.5, 2.2, 1.2))
    colors = np.eye(3) * 2.5
    lights = [core.light(place, color) for place, color in zip(places, colors, strict=True)]
    ball = core.sphere((0, 0.15, 0), 0.35, **white)
    core.scene(0)
    floor = core.plane((0, 1, 0), -FLOOR, **white)
    core.set_scene([ball, floor], lights, core.camera((0.9, 1.3, 1.7), (0, 0, 0)))
    picture = core.render(reflections=False)
    lacking = [number(100 * float(np.mean(picture[..., k] < DARK)), 0) for k in range(3)]
    alt = sentence("tp4.colors_alt", shares=" ; ".join(lacking))
    return show(picture, sentence("tp4.three_colors"), alt=alt)


# ---- Rounding -----------------------------------------------------------------------------------


def surface_errors(core: Core) -> Shown:
    """Draw how far the points hit in scene 0 lie from the surface: floats are rounded.

    Positive is outside of the ball, or above the floor; in billionths of a scene unit.
    """
    ball = core.scene(0).objects[0]
    hits = core.intersect_scene(_rays(core))
    point = np.asarray(hits.position, np.float64)
    from_center = np.linalg.norm(point - np.asarray(ball.center, np.float64), axis=-1)
    on_floor = np.abs(point[..., 1] - FLOOR) < 1e-3
    on_ball = np.abs(from_center - ball.radius) < 1e-3
    errors = {
        "tp4.ball": (from_center - float(ball.radius))[on_ball & ~on_floor] / NANO,
        "tp4.floor": (point[..., 1] + float(np.float32(-FLOOR)))[on_floor] / NANO,
    }
    drawn, axes = new_figure(2, 1, (9, 3.4))
    told = []
    for each, (key, values) in zip(axes, errors.items(), strict=True):
        below = number(100 * float(np.mean(values < 0)), 0) if values.size else "-"
        each.hist(values, bins=np.linspace(-200, 200, 41), color=BLUE, edgecolor="white")
        each.axvline(0, color=RED, lw=2, ls="--")
        each.set(xlabel=sentence("tp4.error"), ylabel=sentence("tp4.points"))
        told.append(sentence("tp4.wrong_side", name=sentence(key), share=below))
        each.set_title(told[-1], fontsize=10)
    return figure(drawn, sentence("tp4.errors_alt", told=" ; ".join(told)))


# ---- Mirrors ------------------------------------------------------------------------------------


def bounce(core: Core, angle: int = 50, length: float = 1.0) -> Shown:
    """Show a ray that arrives at an angle from the normal, and the student's reflected_ray.

    Parameters
    ----------
    angle : int
        Degrees.
    length : float
        Of the direction that arrives.
    """
    turn = np.radians(angle)
    arriving = np.array([np.sin(turn), -np.cos(turn)]) * length
    point = np.zeros((), POINT)
    point["normal"] = (0, 1, 0)
    out = core.reflected_ray(core.ray((*-arriving, 0), (*arriving, 0)), point)
    leaving = np.asarray(out.dir)[:2]
    drawn, axes = new_figure(1, 1, (7, 3.8))
    axes.axhspan(-1.1, 0, color=LIGHT[1])
    _arrow(axes, np.zeros(2), np.array([0, 1.0]), "n", "black")
    _arrow(axes, -arriving, np.zeros(2), "in->dir", BLUE)
    _arrow(axes, np.zeros(2), leaving, "out->dir", ORANGE)
    axes.set(xlim=(-2, 2), ylim=(-1.1, 1.6), aspect="equal", xticks=[], yticks=[])
    size = number(float(np.linalg.norm(leaving)), 2)
    title = sentence("tp4.bounce_title", length=size, depth=out.depth)
    axes.set_title(title)
    return figure(drawn, sentence("tp4.bounce_alt", angle=angle, title=title))


def _arrow(axes: Axes, start: Array, end: Array, name: str, color: str) -> None:
    (x, y), (x0, y0) = end, start
    properties = {"arrowstyle": "->", "color": color, "lw": 2.5}
    axes.annotate("", (x, y), (x0, y0), arrowprops=properties)
    far_x, far_y = 1.1 * (end if np.linalg.norm(end) > np.linalg.norm(start) else start)
    axes.text(far_x, far_y, name, ha="center", va="center", weight="bold")


def _max_depth(core: Core) -> int:
    """Return how often a ray may bounce, with the options of the scene in use."""
    chosen = core.engine.run(core.size, "", lambda stage: stage.session.get("options"))
    return int(chosen["max_depth"])


def _chain(core: Core, ray: Ray) -> tuple[list[Hit], Ray]:
    """Return what a ray meets one time after another, and how it leaves at the end.

    The points come from the student's nearest_hit, the directions from their reflected_ray.
    """
    met: list[Hit] = []
    most = _max_depth(core)
    while len(met) <= most:
        hit = core.nearest_hit(ray)
        if not hit:
            break
        met.append(hit)
        ray = core.reflected_ray(ray, hit)
    return met, ray


def path(core: Core, i: int = 334, j: int = 119, scene: int = 0) -> Shown:
    """Show the points that the ray of a pixel meets, from mirror to mirror, seen from above."""
    content = core.scene(scene)
    picture = core.render(scene)
    ray = core.camera_ray(i + 0.5, j + 0.5)
    met, last = _chain(core, ray)
    drawn, (seen, above) = new_figure(2, 1, (10, 4), width_ratios=(1.4, 1))
    draw(seen, picture, f"(i, j) = ({i}, {j})")
    cross(seen, i, j)
    _from_above(above, content)
    points = [np.asarray(content.camera.position), *(np.asarray(each.position) for each in met)]
    for k, (start, end) in enumerate(pairwise(points)):
        above.plot([start[0], end[0]], [start[2], end[2]], color=BLUE if k else ORANGE, lw=2)
        ground = {"facecolor": LIGHT[0], "edgecolor": "none", "pad": 1}
        above.text(
            end[0], end[2], str(k + 1), va="bottom", weight="bold", clip_on=True, bbox=ground
        )
    end = np.stack([points[-1], points[-1] + FAR * np.asarray(last.dir)])
    above.plot(end[:, 0], end[:, 2], color=GREY, ls="--")
    share = np.prod([np.asarray(each.material.ks).max() for each in met[:-1]])
    values = {"count": len(met), "share": digits(float(share), 2) if met else "0"}
    above.set_title(sentence("tp4.path_title", **values), fontsize=10)
    return figure(drawn, sentence("tp4.path_alt", i=i, j=j, **values))


def _from_above(axes: Axes, content: Scene) -> None:
    """Draw the balls of a scene as seen from above, x to the left as in the picture."""
    for each in content.objects:
        if each.data["type"] == header_number("SPHERE"):
            x, y, z = each.center
            color = tuple(np.clip(np.asarray(each.mat.kd), 0, 1))
            axes.add_patch(
                Circle((x, z), each.radius, facecolor=color, edgecolor=GREY, fill=y < HIGH)
            )
    axes.set(xlim=(1.7, -1.3), ylim=(2.0, -1.0), aspect="equal", xlabel="x", ylabel="z")


def rays_per_depth(core: Core, scene: int = 0) -> Shown:
    """Count the rays of each depth, from the eye's (0) to those that bounced `max_depth` times."""
    core.scene(scene)
    rays, counts, hits = _rays(core), [], np.array([])
    most = _max_depth(core)
    for _ in range(most + 1):
        hits = core.nearest_hit(rays)
        counts.append(hits.hit.size)
        if not hits.hit.any():
            break
        rays = core.reflected_ray(rays[hits.hit], hits[hits.hit])
    shares = [100 * each / counts[0] for each in counts]
    drawn, axes = new_figure(1, 1, (7, 3.2))
    bars = axes.bar(range(len(shares)), shares, color=BLUE)
    axes.bar_label(bars, [digits(each, 3) for each in shares], fontsize=8)
    axes.set(yscale="log", ylim=(0.001, 300), xlim=(-0.6, most + 0.6), xlabel=sentence("tp4.depth"))
    axes.set(ylabel=sentence("tp4.rays_share"), title=sentence("tp4.scene", scene=scene))
    told = " ; ".join(digits(each, 3) for each in shares)
    return figure(drawn, sentence("tp4.depths_alt", scene=scene, shares=told))


def facing_mirrors(core: Core, max_depth: int = 2) -> Picture:
    """Draw a ball between two mirrors that face each other."""
    mirror = {"kd": (0.02, 0.02, 0.02), "ks": (0.85, 0.9, 0.85), "shininess": 2000.0}
    walls = [core.plane((0, 0, side), 2.0, **mirror) for side in (1, -1)]
    ball = core.sphere((-0.1, 0, 0.2), 0.35, kd=(0.9, 0.3, 0.1), ks=(0.1, 0.1, 0.1))
    floor = core.plane((0, 1, 0), 0.6, kd=(0.5, 0.6, 0.8))
    core.scene(0)
    core.set_scene(
        [*walls, ball, floor],
        core.light((0.5, 3, 0.5), (3, 3, 3)),
        core.camera((0.9, 0.7, 1.5), (-0.3, 0.1, -1)),
    )
    return core.render(max_depth=max_depth)


def tree(depth: int = 2, branches: int = 1) -> Shown:
    """Draw the rays that one pixel asks for when each hit sends `branches` rays on."""
    drawn, axes = new_figure(1, 1, (7, 3.4))
    level = [0.5]
    axes.plot([0.5, 0.5], [1, 0], color=ORANGE, lw=2)
    for generation in range(1, min(depth, SHOWN_GENERATIONS) + 1):
        width = 0.25 / branches ** (generation - 1) if branches > 1 else 0.0
        below = [x + side for x in level for side in ((-width, width) if branches > 1 else (0.03,))]
        for n, x in enumerate(below):
            parent = level[n // branches]
            axes.plot([parent, x], [1 - generation, -generation], color=BLUE, lw=1.5)
        axes.plot(level, [1 - generation] * len(level), "o", color="black", ms=4)
        level = below
    total = sum(branches**k for k in range(depth + 1))
    axes.set(xlim=(0, 1), xticks=[], ylabel=sentence("tp4.depth"))
    axes.set_yticks(
        [0.5 - k for k in range(min(depth, SHOWN_GENERATIONS) + 1)],
        [str(k) for k in range(min(depth, SHOWN_GENERATIONS) + 1)],
    )
    title = sentence("tp4.tree_title", depth=depth, branches=branches, total=number(total, 0))
    axes.set_title(title)
    return figure(drawn, sentence("tp4.tree_alt", title=title))
