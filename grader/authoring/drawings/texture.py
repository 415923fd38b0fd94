"""Draw core_c/texture.ppm: the map of an invented planet, for the globes of scenes 6 and 10.

The map is a plain one: longitude grows evenly along a row, from -180 degrees, and the rows go
from the north pole to the south pole. Everything is computed on the sphere itself, so that the
picture has no seam and no pinch at the poles. A faint graticule every 30 degrees shows what u and v
mean.
Run it as ``python -m grader.authoring.drawings.texture [--check]``.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from grader.course.exercises import CORE
from grader.files import write_whole

WIDTH, HEIGHT = 512, 256
TEXTURE = CORE / "texture.ppm"

Floats = npt.NDArray[np.float64]
Bytes = npt.NDArray[np.uint8]

# Another system's sine may differ by its last bit, and turn the rounding of a byte.
TOLERANCE = 1

# Colours by height above the sea (0), blended in between: the coast is narrow, but not a step.
SEA_HEIGHTS = (-0.22, -0.08, -0.015, -0.002, 0.004)
SEA = ((8, 30, 84), (16, 62, 132), (44, 116, 172), (92, 170, 196), (222, 204, 150))
LAND_HEIGHTS = (0.0, 0.06, 0.14, 0.24, 0.3)
GREEN = ((104, 150, 62), (58, 122, 52), (96, 116, 66), (136, 126, 112), (236, 236, 232))
OCHRE = ((224, 190, 116), (206, 152, 82), (168, 112, 70), (150, 124, 106), (214, 196, 176))
SNOW = (246, 249, 252)
LINE = (250, 250, 235)


def directions() -> Floats:
    """Return the unit direction of each texel's centre, shape (HEIGHT, WIDTH, 3).

    As in TP3.B2: u = 0.5 + atan2(x, z) / 2 pi along a row, v = acos(y) / pi down the rows.
    """
    longitude = ((np.arange(WIDTH) + 0.5) / WIDTH - 0.5) * 2 * np.pi
    polar = (np.arange(HEIGHT)[:, None] + 0.5) / HEIGHT * np.pi
    x, z = np.sin(polar) * np.sin(longitude), np.sin(polar) * np.cos(longitude)
    return np.stack([x, np.broadcast_to(np.cos(polar), x.shape), z], axis=-1)


def value_noise(points: Floats, cells: int, random: np.random.RandomState) -> Floats:
    """Return noise in [-1, 1] at points of [-1, 1]^3: random values on a grid, blended smoothly.

    Parameters
    ----------
    points : array of shape (..., 3)
    cells : int
        Cells of the grid along each axis.
    random : RandomState
        The old generator, because numpy promises that its numbers never change.

    Returns
    -------
    array of shape (...)
    """
    grid = random.uniform(-1.0, 1.0, (cells + 1,) * 3)
    position = np.clip((points + 1) / 2, 0, 1) * cells
    corner = np.minimum(position.astype(int), cells - 1)
    t = position - corner
    weight = t * t * (3 - 2 * t)
    total = np.zeros(points.shape[:-1])
    for step in np.ndindex(2, 2, 2):
        share = np.where(step, weight, 1 - weight).prod(axis=-1)
        total += share * grid[tuple(np.moveaxis(corner + step, -1, 0))]
    return total


def fractal_noise(points: Floats, seed: int, cells: int = 3, octaves: int = 6) -> Floats:
    """Return a sum of noises, each twice as fine and half as high as the one before."""
    random = np.random.RandomState(seed)
    return sum(
        (value_noise(points, cells << k, random) / 2**k for k in range(octaves)),
        start=np.zeros(points.shape[:-1]),
    )


def ramp(x: Floats, stops: Sequence[float], colors: Sequence[Sequence[int]]) -> Floats:
    """Return the colour at each x, interpolated between stops; shape x.shape + (3,), 0 to 255."""
    table = np.asarray(colors, dtype=float)
    return np.stack([np.interp(x, stops, table[:, c]) for c in range(3)], axis=-1)


def blend(under: Floats, over: Sequence[int] | Floats, share: Floats) -> Floats:
    """Return colours with another laid over them; `share` in [0, 1] lacks the colour axis."""
    return under + share[..., None] * (np.asarray(over, dtype=float) - under)


def smooth(x: Floats, low: float, high: float) -> Floats:
    """Return 0 below `low`, 1 above `high`, and a line between."""
    return np.clip((x - low) / (high - low), 0, 1)


def graticule() -> Floats:
    """Return how much of each texel a line covers: every 30 degrees, the equator stronger."""
    share = np.zeros((HEIGHT, WIDTH))
    longitude = (np.arange(WIDTH) + 0.5) / WIDTH * 12
    latitude = (np.arange(HEIGHT) + 0.5) / HEIGHT * 6
    share[:, np.abs(longitude - np.round(longitude)) * WIDTH / 12 < 1] = 0.3
    share[np.abs(latitude - np.round(latitude)) * HEIGHT / 6 < 1] = 0.3
    share[HEIGHT // 2 - 1 : HEIGHT // 2 + 1] = 0.5
    polar = np.abs(latitude - 3) > 2.5  # the meridians would crowd there
    share[polar] = 0
    return share


def planet() -> Bytes:
    """Return the map, shape (HEIGHT, WIDTH, 3), north first."""
    points = directions()
    bend = np.stack([fractal_noise(points, seed, 4, 3) for seed in (1, 2, 3)], axis=-1)
    bent = np.clip(points + 0.12 * bend, -1, 1)  # winding coasts instead of the grid's own shapes
    height = 0.3 * fractal_noise(bent, 11) - 0.02
    north = np.abs(points[..., 1])
    dry = smooth(fractal_noise(bent, 23, 4, 5) - 1.2 * np.abs(north - 0.4), -0.5, 0.1)
    land = blend(ramp(height, LAND_HEIGHTS, GREEN), ramp(height, LAND_HEIGHTS, OCHRE), dry)
    color = blend(ramp(height, SEA_HEIGHTS, SEA), land, smooth(height, 0.004, 0.012))
    cold = north + 0.5 * np.maximum(height, 0) + 0.06 * fractal_noise(points, 31, 12, 4)
    color = blend(color, SNOW, smooth(cold, 0.94, 0.965))
    color = blend(color, LINE, graticule())
    return np.rint(color).astype(np.uint8)


def ppm(picture: Bytes) -> bytes:
    """Return the picture as a binary PPM file."""
    height, width, _ = picture.shape
    return b"P6\n%d %d\n255\n" % (width, height) + picture.tobytes()


def differs(path: Path, picture: Bytes) -> str:
    """Return in what the file is not this picture, or an empty string."""
    try:
        found = path.read_bytes()
    except OSError as error:
        return f"cannot be read ({error.strerror})"
    expected = ppm(picture)
    head = len(expected) - picture.size
    if len(found) != len(expected) or found[:head] != expected[:head]:
        return "another size or format"
    gap = np.abs(np.frombuffer(found[head:], np.uint8).astype(int) - picture.reshape(-1)).max()
    return f"differs by up to {gap} levels" if gap > TOLERANCE else ""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return 0, or 1 after one line on stderr."""
    parser = argparse.ArgumentParser(
        prog="python -m grader.authoring.drawings.texture", description=__doc__
    )
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--out", type=Path, default=TEXTURE, metavar="FILE")
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 on a drift")
    arguments = parser.parse_args(argv)
    cure = "run `python -m grader.authoring.drawings.texture`"
    if arguments.check:
        problem = differs(arguments.out, planet())
    else:
        try:
            write_whole(arguments.out, ppm(planet()))
            return 0
        except OSError as error:
            problem, cure = f"cannot be written ({error.strerror})", "give a writable --out file"
    if problem:
        print(f"{arguments.out.name}: {problem}; {cure}", file=sys.stderr)
    return 1 if problem else 0


if __name__ == "__main__":
    sys.exit(main())
