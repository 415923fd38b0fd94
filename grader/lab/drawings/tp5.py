"""Drawings for TP5's notebook: Fresnel's curves, refraction, a fractal.

Those that take `core` draw what the student's own functions answer.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

from grader.lab.bridge.core import Core
from grader.lab.display.card import Shown, table
from grader.lab.display.picture import draw, figure, new_figure, show
from grader.lab.display.plots import (
    BLUE,
    GREEN,
    GREY,
    LIGHT,
    ON_DARK,
    ORANGE,
    RED,
    SKY,
    cross,
    number,
    sentence,
)

Array = npt.NDArray[Any]

COARSE = (160, 90)  # pixels: enough for maps that need many calls
ANGLES = np.linspace(0, 90, 181)  # degrees from the normal
# Refraction indices; and reflectances at normal incidence of metals (linear RGB, rounded).
INDICES = {"tp5.water": 1.33, "tp5.glass": 1.5, "tp5.diamond": 2.42}
GOLD, SILVER = (1.0, 0.77, 0.34), (0.95, 0.93, 0.88)
HALF = 0.5  # of the light: there a floor counts as a mirror
AIR = 1.0


# ---- Fresnel ------------------------------------------------------------------------------------


def _schlick(core: Core, kr: npt.ArrayLike, degrees: Array) -> Array:
    """Return the student's fresnel_schlick for angles from the normal, shape (n, 3)."""
    turn = np.radians(degrees)
    view = np.stack([np.sin(turn), np.cos(turn), np.zeros_like(turn)], axis=-1)
    return np.asarray(core.fresnel_schlick(kr, (0, 1, 0), view))


def _exact(index: float, degrees: Array) -> Array:
    """Return what Fresnel's own equations give for a transparent material, unpolarised light."""
    turn = np.radians(degrees)
    into = np.sqrt(1 - (np.sin(turn) / index) ** 2)
    across = (np.cos(turn) - index * into) / (np.cos(turn) + index * into)
    along = (into - index * np.cos(turn)) / (into + index * np.cos(turn))
    share: Array = (across**2 + along**2) / 2
    return share


def reflectances(core: Core) -> Shown:
    """Show what the student's reflectance gives for materials in air, in %."""
    rows = []
    for key, index in INDICES.items():
        share = 100 * core.reflectance(AIR, index)
        rows.append([sentence(key), number(index, 2), f"{number(share, 1)} %"])
    heads = [sentence("tp5.material"), "n2", "reflectance(1, n2)"]
    return table(heads, rows)


def fresnel_curves(core: Core) -> Shown:
    """Draw the student's fresnel_schlick by the angle: transparent materials, then metals."""
    drawn, (clear, metal) = new_figure(2, 1, (9.5, 4), sharey=True)
    styles = ((SKY, ":"), (BLUE, "-"), (GREEN, "--"))
    told = []
    for (key, index), (color, style) in zip(INDICES.items(), styles, strict=True):
        kr = core.reflectance(AIR, index)
        curve = _schlick(core, (kr, kr, kr), ANGLES)[:, 0]
        clear.plot(ANGLES, curve, color=color, ls=style, lw=2, label=sentence(key))
        told.append(f"{sentence(key)} {number(float(curve[0]), 3)}")
    exact = _exact(INDICES["tp5.glass"], ANGLES)
    clear.plot(ANGLES, exact, color="black", lw=0.8, label=sentence("tp5.exact"))
    for channel, (key, color) in enumerate((("red", RED), ("green", GREEN), ("blue", BLUE))):
        for kr_metal, style in ((GOLD, "-"), (SILVER, ":")):
            name = sentence("tp5.gold" if kr_metal is GOLD else "tp5.silver")
            curve = _schlick(core, kr_metal, ANGLES)[:, channel]
            label = f"{name}, {sentence(f'plot.{key}')}"
            metal.plot(ANGLES, curve, color=color, ls=style, lw=2, label=label)
            if kr_metal is GOLD:  # in grey only their places tell its components apart
                metal.text(4, curve[0] - 0.06, "xyz"[channel], weight="bold")
    clear.set(ylabel=sentence("tp5.share"), ylim=(-0.03, 1.03))
    for each in (clear, metal):
        each.set(xlabel=sentence("tp5.angle"), xlim=(0, 90))
        each.legend(fontsize=7)
    return figure(drawn, sentence("tp5.curves_alt", told=" ; ".join(told)))


def floor_map(core: Core) -> Shown:
    """Map the share that each pixel of scene 0 mirrors; a line where it is one half."""
    core.scene(0)
    (width, height), (columns, rows) = core.size, COARSE
    x, y = np.meshgrid(np.arange(columns) + 0.5, np.arange(rows) + 0.5)
    rays = core.camera_ray(x * width / columns, y * height / rows)
    hits = core.nearest_hit(rays)
    shares = np.full(hits.shape, np.nan)
    if hits.hit.any():
        met = hits[hits.hit]
        found = core.fresnel_schlick(met.material.data["kr"], met.normal, -rays[hits.hit].dir)
        shares[hits.hit] = np.asarray(found).mean(axis=-1)
    drawn, axes = new_figure(1, 1, (7, 4))
    draw(axes, shares, sentence("tp5.map_title"), label=sentence("tp5.share"), limits=(0, 1))
    known = np.nan_to_num(shares)
    if known.min() < HALF < known.max():
        axes.contour(known, levels=[HALF], colors=ON_DARK, linewidths=1.5)
    told = number(100 * float(np.mean(known > HALF)), 1)
    return figure(drawn, sentence("tp5.map_alt", share=told))


def probe(core: Core, i: int = 100, j: int = 200) -> Shown:
    """Show a pixel of scene 0, and where its angle stands on its material's curve."""
    core.scene(0)
    picture = core.render(scene=0)
    ray = core.camera_ray(i + 0.5, j + 0.5)
    hit = core.nearest_hit(ray)
    drawn, (seen, curve) = new_figure(2, 1, (9.5, 3.6), width_ratios=(1.4, 1))
    draw(seen, picture, f"(i, j) = ({i}, {j})")
    cross(seen, i, j)
    curve.set(xlim=(0, 90), ylim=(-0.03, 1.03), xlabel=sentence("tp5.angle"))
    curve.set_ylabel(sentence("tp5.share"))
    if not hit:
        curve.set_title(sentence("tp5.sky"))
        return figure(drawn, sentence("tp5.probe_alt", i=i, j=j, found=sentence("tp5.sky")))
    kr = hit.material.kr
    cosine = -float(np.dot(ray.dir, hit.normal) / np.linalg.norm(ray.dir))
    angle = float(np.degrees(np.arccos(np.clip(cosine, 0, 1))))
    share = float(_schlick(core, kr, np.array([angle])).mean())
    curve.plot(ANGLES, _schlick(core, kr, ANGLES).mean(axis=1), color=BLUE, lw=2)
    curve.plot(angle, share, "o", color=ORANGE, mec="black", ms=10)
    values = {"kr": number(float(np.mean(kr)), 2), "angle": number(angle, 0)}
    found = sentence("tp5.found", share=number(share, 2), **values)
    curve.set_title(found, fontsize=10)
    return figure(drawn, sentence("tp5.probe_alt", i=i, j=j, found=found))


# ---- Refraction ---------------------------------------------------------------------------------


def snell(core: Core, angle: int = 40, index: float = 1.5, inside: bool = False) -> Shown:
    """Show a ray at a surface, and what the student's refracted_ray and reflected_ray make of it.

    Parameters
    ----------
    angle : int
        Between the ray and the normal, degrees.
    index : float
        Refraction index below the surface; 1 above.
    inside : bool
        Whether the ray comes from below.
    """
    up = -1.0 if inside else 1.0
    turn = np.radians(angle)
    arriving = np.array([np.sin(turn), -up * np.cos(turn), 0])
    mat = core.material(refraction_index=index)
    kinds = [("position", "f4", (3,)), ("normal", "f4", (3,)), ("mat", mat.data.dtype)]
    point = np.zeros((), np.dtype(kinds))
    point["normal"], point["mat"] = (0, 1, 0), mat.data
    ray = core.ray(-arriving, arriving)
    through, mirrored = core.refracted_ray(ray, point), core.reflected_ray(ray, point)
    drawn, axes = new_figure(1, 1, (6.5, 4.4))
    axes.axhspan(-1.3, 0, color=LIGHT[1])
    axes.axvline(0, color=GREY, ls=":", lw=1)
    _arrow(axes, -arriving, np.zeros(3), BLUE)
    _arrow(axes, np.zeros(3), np.asarray(mirrored.dir), GREY, "--")
    title = sentence("tp5.total")
    if through is not None:
        out = np.asarray(through.dir)
        _arrow(axes, np.zeros(3), out, ORANGE)
        bent = float(np.degrees(np.arctan2(out[0], -up * out[1])))
        title = sentence("tp5.bent", angle=angle, out=number(bent, 1))
    axes.text(-1.5, 1.1, "n = 1")
    axes.text(-1.5, -1.2, f"n = {number(index, 2)}")
    axes.set(xlim=(-1.6, 1.6), ylim=(-1.3, 1.3), aspect="equal", xticks=[], yticks=[], title=title)
    return figure(
        drawn, sentence("tp5.snell_alt", angle=angle, index=number(index, 2), title=title)
    )


def _arrow(axes: Axes, start: Array, end: Array, color: str, style: str = "-") -> None:
    properties = {"arrowstyle": "->", "color": color, "lw": 2.5, "ls": style}
    (x, y), (x0, y0) = end[:2], start[:2]
    axes.annotate("", (x, y), (x0, y0), arrowprops=properties)


# ---- A fractal ----------------------------------------------------------------------------------


def fractal(core: Core, depth: int = 2) -> Shown:
    """Draw what the student's populate_spheres puts on a ball, from nothing."""
    core.scene(0)
    lights = [core.light((-1.5, 4, 5), (2.4, 2.4, 2.4)), core.light((6, 3, 2.5), (1.3, 1.1, 0.9))]
    core.set_scene([], lights, core.camera((1.1, 1.2, 1.7), (0, 0.25, 0)))
    core.populate_spheres((0, 0, 0), 0.6, (0, 1, 0), depth)
    content = core.scene()
    count = len(content.objects)
    title = sentence("tp5.fractal", depth=depth, count=number(count, 0))
    return show(core.render(content), title, alt=title)
