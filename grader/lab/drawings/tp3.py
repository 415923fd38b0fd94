"""Drawings for TP3's notebook: cosines, half vectors, lobes, and the student's shade on a ball.

Those that take `core` draw what the student's own functions answer.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

from grader.lab.bridge.core import Core
from grader.lab.display.card import Shown, table
from grader.lab.display.picture import Picture, draw, figure, new_figure
from grader.lab.display.plots import (
    BLUE,
    GREEN,
    GREY,
    INK,
    LIGHT,
    ON_DARK,
    ORANGE,
    RED,
    number,
    sentence,
)

Array = npt.NDArray[Any]

BALL = 121  # pixels across of the balls drawn here
BACKGROUND = (0.2, 0.2, 0.6)
MOST_TAKEN = 30  # levels of 255: the end of the scale of without_clamp
KD, KS = 0.5, 0.5  # of the surface of the polar plot


def _turn(degrees: float) -> Array:
    """Return the direction at an angle from the vertical, positive to the right."""
    angle = np.radians(degrees)
    return np.array([np.sin(angle), np.cos(angle)])


def _arrow(axes: Axes, direction: Array, name: str, color: str, style: str = "-") -> None:
    properties = {"arrowstyle": "->", "color": color, "lw": 2.5, "ls": style}
    x, y = direction
    axes.annotate("", (x, y), (0, 0), arrowprops=properties)
    axes.text(1.12 * x, 1.12 * y, name, ha="center", va="center", weight="bold")


def _ball() -> tuple[Array, Array]:
    """Return the unit normals of a ball seen from the front, and where it is in the picture.

    Returns
    -------
    normals : array (BALL, BALL, 3), the bottom row first
    inside : array (BALL, BALL) of booleans
    """
    side = np.linspace(-1.1, 1.1, BALL)
    x, y = np.meshgrid(side, side)
    square = x**2 + y**2
    z = np.sqrt(np.clip(1 - square, 0, None))
    return np.stack([x, y, z], axis=-1), square < 1


def _toward(azimuth: float, height: float) -> Array:
    """Return the direction of a light: degrees from the eye to the right, and upwards."""
    a, h = np.radians([azimuth, height])
    return np.array([np.sin(a) * np.cos(h), np.sin(h), np.cos(a) * np.cos(h)])


# ---- n.l and h --------------------------------------------------------------------------------


def patch(angle: int = 40) -> Shown:
    """Show a beam of width 1 that falls on a surface at an angle (degrees) from its normal."""
    toward = _turn(-angle)
    across = np.array([toward[1], -toward[0]])
    spread = 1 / float(np.cos(np.radians(angle)))
    drawn, axes = new_figure(1, 1, (7.5, 3.2))
    axes.axhspan(-0.3, 0, color=LIGHT[1])
    edges = [np.array([side * spread / 2, 0.0]) for side in (-1, 1)]
    for edge in edges:
        axes.plot(*np.transpose([edge, edge + 6 * toward]), color=ORANGE, lw=2)
    beam = np.array([edges[0], edges[0] + 6 * toward, edges[1] + 6 * toward, edges[1]])
    axes.fill(*beam.T, color=ORANGE, alpha=0.25)
    axes.plot([-spread / 2, spread / 2], [0, 0], color=RED, lw=5)
    axes.plot(*np.transpose([1.6 * toward - across / 2, 1.6 * toward + across / 2]), "k", lw=3)
    axes.annotate("", (0, 1.1), (0, 0), arrowprops={"arrowstyle": "->", "color": BLUE, "lw": 2})
    axes.text(0.12, 0.9, "n", weight="bold")
    axes.set(xlim=(-6, 6), ylim=(-0.3, 2.4), aspect="equal", xticks=[], yticks=[])
    values = {"width": number(spread, 2), "share": number(1 / spread, 2), "angle": angle}
    axes.set_title(sentence("tp3.spread", **values))
    return figure(drawn, sentence("tp3.patch_alt", **values))


def n_dot_l(azimuth: int = 60, height: int = 30) -> Shown:
    """Map n.l on a ball seen from the front; a line where it changes sign."""
    normals, inside = _ball()
    values = np.where(inside, normals @ _toward(azimuth, height), np.nan)
    drawn, axes = new_figure(1, 1, (5.6, 4.4))
    draw(axes, values, label="n . l", limits=(-1, 1))
    if np.nanmin(values) < 0 < np.nanmax(values):
        axes.contour(values, levels=[0], colors=ON_DARK, linewidths=2)
    lit = number(100 * float(np.mean(values[inside] > 0)), 0)
    axes.set_title(sentence("tp3.lit", share=lit))
    return figure(drawn, sentence("tp3.ball_alt", azimuth=azimuth, height=height, share=lit))


def half_vector(light: int = -40, view: int = 20) -> Shown:
    """Show l, v and h above a surface; angles in degrees from the normal, right is positive."""
    toward_light, eye = _turn(light), _turn(view)
    half = (toward_light + eye) / np.linalg.norm(toward_light + eye)
    drawn, axes = new_figure(1, 1, (6.5, 3.8))
    axes.axhspan(-0.15, 0, color=LIGHT[1])
    _arrow(axes, np.array([0.0, 1.0]), "n", "black", "--")
    _arrow(axes, toward_light, "l", ORANGE)
    _arrow(axes, eye, "v", GREEN)
    _arrow(axes, half, "h", BLUE)
    axes.set(xlim=(-1.6, 1.6), ylim=(-0.15, 1.3), aspect="equal", xticks=[], yticks=[])
    told = number(float(half[1]), 2)
    axes.set_title(f"h . n = {told}")
    return figure(drawn, sentence("tp3.half_alt", light=light, view=view, dot=told))


# ---- Lobes ------------------------------------------------------------------------------------


def _specular(angles: Array, light: float, shininess: float) -> Array:
    """Return (h.n)^s (s + 8) / (8 pi) for directions of the eye, angles in radians."""
    cosine = np.cos((angles + np.radians(light)) / 2)  # h stands half-way between l and v
    lobe: Array = cosine**shininess * (shininess + 8) / (8 * np.pi)
    return lobe


def lobe(light: int = -40, shininess: float = 20) -> Shown:
    """Draw how much light leaves in each direction, in polar coordinates."""
    angles = np.radians(np.linspace(-90, 90, 721))
    cosine = float(np.cos(np.radians(light)))
    diffuse = np.full_like(angles, cosine * KD / np.pi)
    whole = diffuse + cosine * KS * _specular(angles, light, shininess)
    drawn, axes = new_figure(1, 1, (7, 4.2), subplot_kw={"projection": "polar"})
    axes.plot(angles, diffuse, color=GREY, ls="--", label=sentence("tp3.diffuse"))
    axes.plot(angles, whole, color=BLUE, lw=2, label=sentence("tp3.whole"))
    top = 1.08 * float(whole.max())
    axes.plot(np.radians([light, light]), [0, top], color=ORANGE, ls=":", lw=3, label="l")
    axes.set_theta_zero_location("N")
    axes.set_theta_direction(-1)
    axes.set(thetamin=-90, thetamax=90, ylim=(0, top))
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, 0.12), ncols=3, fontsize=8)
    axes.set_title(f"s = {number(shininess, 0)}")
    peak = number(float(np.degrees(angles[whole.argmax()])), 0)
    return figure(drawn, sentence("tp3.lobe_alt", light=light, s=number(shininess, 0), peak=peak))


def normalisation() -> Shown:
    """Compare lobes with and without the factor: their curves, and the light they send in all."""
    angles = np.radians(np.linspace(0, 90, 901))
    drawn, (curves, totals) = new_figure(2, 1, (9, 3.8))
    for shininess, color, width in ((5, GREEN, 1), (20, BLUE, 2), (200, RED, 4)):
        factor = (shininess + 8) / (8 * np.pi)
        values = _specular(angles, 0, shininess)
        degrees = np.degrees(angles)
        curves.plot(degrees, values, color=color, lw=width, label=f"s = {shininess}")
        curves.plot(degrees, values / factor, color=color, lw=width, ls=":")
    curves.set(xlabel=sentence("tp3.eye_angle"), ylabel=sentence("tp3.strength"), xlim=(0, 60))
    curves.legend(fontsize=8)
    exponents = np.geomspace(1, 1000, 40)
    weight = 2 * np.pi * np.cos(angles) * np.sin(angles)
    sums = [float(np.trapezoid(_specular(angles, 0, s) * weight, angles)) for s in exponents]
    bare = np.array(sums) / (exponents + 8) * 8 * np.pi
    totals.semilogx(exponents, sums, color=BLUE, label=sentence("tp3.with_factor"))
    totals.semilogx(exponents, bare, color=BLUE, ls="--", label=sentence("tp3.without_factor"))
    totals.set(xlabel="s", ylabel=sentence("tp3.total"), ylim=(0, 1.5))
    totals.legend(fontsize=8)
    return figure(drawn, sentence("tp3.normalisation_alt"))


# ---- The student's shade ------------------------------------------------------------------------


def shaded_ball(core: Core, azimuth: int = 40, shininess: int = 20) -> Shown:
    """Show the student's shade on a ball: the diffuse part, the reflection, and both."""
    core.scene()  # the options of core reach the program with its scene
    normals, inside = _ball()
    toward = _toward(azimuth, 35)
    red = (0.9, 0.25, 0.1)
    parts = {"tp3.diffuse": (red, 0.0), "tp3.specular": ((0, 0, 0), 0.3), "tp3.both": (red, 0.3)}
    drawn, axes = new_figure(3, 1, (9, 3.4))
    lit = 0.0
    for each, (key, (kd, ks)) in zip(axes, parts.items(), strict=True):
        mat = core.material(kd, (ks, ks, ks), shininess)
        colors = core.shade(normals[inside], (0, 0, 1), toward, (3, 3, 3), mat)
        picture = np.full((BALL, BALL, 3), BACKGROUND, np.float32)
        picture[inside] = colors
        draw(each, picture, sentence(key))
        lit = float(np.mean(np.asarray(colors).max(axis=-1) > 0))
    told = number(100 * lit, 0)
    return figure(drawn, sentence("tp3.shade_alt", azimuth=azimuth, s=shininess, share=told))


def powers() -> Shown:
    """Show what powf gives for a negative number."""
    rows = []
    for exponent in (20.0, 21.0, 0.5):
        with np.errstate(invalid="ignore"):
            value = np.float32(-0.5) ** np.float32(exponent)
        rows.append([f"powf(-0.5f, {exponent:.1f}f)", f"{value:.3g}"])
    return table(["C", ""], rows)


def one_light_at_a_time(core: Core, scene: int = 4) -> Shown:
    """Draw a scene with each of its lights alone, then with all of them."""
    content = core.scene(scene)
    pictures = [
        core.render(content.replaced(lights=content.lights[k : k + 1]))
        for k in range(len(content.lights))
    ]
    pictures.append(core.render(scene))
    drawn, axes = new_figure(2, 2, (9, 6))
    means = []
    for k, (each, picture) in enumerate(zip(axes.flat, pictures, strict=True)):
        last = k == len(pictures) - 1
        draw(each, picture, sentence("tp3.sum") if last else f"lights[{k}]")
        means.append(number(float(np.mean(picture)), 2))
    told = " ; ".join(means)
    return figure(drawn, sentence("tp3.lights_alt", scene=scene, means=told))


def without_clamp(core: Core) -> Shown:
    """Draw the diffuse light of scenes 0 and 4, and what it loses when n.l is not clamped at 0."""
    drawn, axes = new_figure(2, 2, (9.5, 5.6))
    changed = {}
    for row, scene in zip(axes, (0, 4), strict=True):
        clamped, free = (_diffuse(core, scene, limit) for limit in (0.0, -1.0))
        seen = [np.clip(each, 0, 1) * 255 for each in (clamped, free)]
        taken = np.asarray(seen[0] - seen[1]).max(axis=2)
        draw(row[0], clamped, sentence("tp3.clamped", scene=scene))
        draw(row[1], taken, sentence("tp3.taken"), label="/ 255", limits=(0, MOST_TAKEN))
        changed[scene] = number(100 * float(np.mean(taken >= 1)), 1)
    return figure(drawn, sentence("tp3.clamp_alt", zero=changed[0], four=changed[4]))


def _diffuse(core: Core, scene: int, least: float) -> Picture:
    """Return kd / pi max(n.l, least) I summed over the lights of a scene, without shadows."""
    content = core.scene(scene)
    x, y = np.meshgrid(np.arange(160) * 4 + 2, np.arange(90) * 4 + 2)
    hits = core.intersect_scene(core.camera_ray(x * core.size[0] / 640, y * core.size[1] / 360))
    total = np.zeros((*hits.shape, 3), np.float32)
    for each in content.lights:
        toward = np.asarray(each.position) - hits.position
        toward = toward / np.linalg.norm(toward, axis=-1, keepdims=True)
        cosine = np.maximum((hits.normal * toward).sum(axis=-1, keepdims=True), least)
        total += hits.material.kd / np.pi * cosine * np.asarray(each.col)
    total[~hits.hit] = BACKGROUND
    return total.view(Picture)


# ---- Patterns -----------------------------------------------------------------------------------


def floor_and_int() -> Shown:
    """Compare the cubes of a checkerboard along an axis, numbered by floorf and by (int)."""
    drawn, axes = new_figure(1, 1, (7.5, 2.4))
    for y, (name, rule) in enumerate((("(int)x", np.trunc), ("floorf(x)", np.floor))):
        for middle in np.arange(-3, 3, 0.5) + 0.25:
            k = int(rule(middle))
            axes.barh(y, 0.5, left=middle - 0.25, height=0.7, color=(BLUE, LIGHT[1])[k % 2])
        for k in np.unique(rule(np.arange(-3, 3, 0.5) + 0.25)):
            inside = [x for x in np.arange(-3, 3, 0.5) + 0.25 if rule(x) == k]
            middle = float(np.mean(inside))
            color = ON_DARK if k % 2 == 0 else INK
            axes.text(middle, y, f"{k + 0:.0f}", ha="center", va="center", color=color)
        axes.text(-3.1, y, name, ha="right", va="center")
    axes.set(xlim=(-4, 3), ylim=(-0.5, 1.5), yticks=[], xlabel="x")
    return figure(drawn, sentence("tp3.floor_alt"))


def checkered_ball(core: Core, size: float = 0.4) -> Picture:
    """Return the student's checker_color on a ball of radius 1."""
    points, inside = _ball()
    mat = core.material((0.9, 0.85, 0.7), kd2=(0.2, 0.25, 0.5), pattern=1, pattern_size=size)
    picture = np.full((BALL, BALL, 3), BACKGROUND, np.float32)
    picture[inside] = core.checker_color(mat, points[inside])
    return np.repeat(np.repeat(picture, 3, axis=0), 3, axis=1).view(Picture)
