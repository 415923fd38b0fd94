"""How far a picture is from the accepted ones.

The accepted readings of the handout differ at edges and by rounding: between the least and the most
that they give, pixel by pixel, everything is right. What lies outside counts where the neighbours'
rays take the same path (the calm pixels), or in the tile where most of it lies.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from grader.checking.shapes import Image, Mask

Floats = npt.NDArray[np.float32]

TILE = 16  # pixels a side
LEVEL = 1 / 255
# How far outside a pixel is wrong, for the share and for the tile.
FAR = (3 * LEVEL, 3 * LEVEL)
FAR_SMOOTH = (8 * LEVEL, 4 * LEVEL)
FAR_MEANS = 6 * LEVEL


@dataclass(frozen=True)
class Band:
    """Where samples matter: pixels (flat indices) with their colours, with and without samples.

    `smooth` and `plain` have shape (count, 3), 0 to 1.
    """

    pixels: npt.NDArray[np.intp]
    smooth: Floats
    plain: Floats


@dataclass(frozen=True)
class Envelope:
    """The accepted colours of a picture, 0 to 1: planes of shape (3, height, width)."""

    low: Floats
    high: Floats
    calm: Mask
    band: Band | None = None  # of a picture with several samples a pixel
    is_flat: bool = False  # kd alone: every pixel counts for the share
    by_means: bool = False  # drawn by lot: the means of tiles count, not pixels

    @property
    def far(self) -> float:
        """How far outside a pixel is wrong."""
        return FAR_MEANS if self.by_means else FAR_SMOOTH[0] if self.band else FAR[0]


@dataclass(frozen=True)
class Measures:
    """What was measured; each is wrong above its limit."""

    share: float  # of the pixels, those that count and are wrong
    tile: float  # share of wrong pixels in the worst tile; of means, how far the worst is outside
    edges: float = 0.0  # what part of the samples' effect is missing
    worst: tuple[int, int] = (0, 0)  # row and column of the worst tile's corner

    def exceeds(self, limits: PictureLimits) -> float:
        """Return the largest of the measures as a multiple of its limit."""
        return max(
            self.share / limits.share, self.tile / limits.tile, self.edges / (limits.edges or 1)
        )


@dataclass(frozen=True)
class PictureLimits:
    """The most that each measure may be."""

    share: float
    tile: float
    edges: float = 0.0  # 0: not measured


def outside(picture: Image, envelope: Envelope) -> Floats:
    """Return how far each pixel is outside, shape (height, width), in the worst channel.

    `picture` has shape (height, width, 3); it is clamped to [0, 1] as the picture's file is.
    """
    worst = np.zeros(picture.shape[:2], np.float32)
    for channel in range(3):
        plane = np.clip(picture[:, :, channel], 0, 1)
        if envelope.by_means:
            plane = tile_means(plane)
        np.maximum(worst, envelope.low[channel] - plane, out=worst)
        np.maximum(worst, plane - envelope.high[channel], out=worst)
    return worst


def measure(picture: Image, envelope: Envelope, error: Floats) -> Measures:
    """Measure a finite picture; `error` is what `outside` gives for it."""
    wrong = error > envelope.far
    if envelope.by_means:
        row, column = divmod(int(error.argmax()), error.shape[1])
        return Measures(float(wrong.mean()), float(error.max()), worst=(row, column))
    if not (envelope.band or envelope.is_flat):
        wrong &= envelope.calm
    far_in_tile = FAR_SMOOTH[1] if envelope.band else FAR[1]
    tile, worst = worst_tile(error > far_in_tile)
    edges = _edges(picture, envelope.band) if envelope.band else 0.0
    return Measures(float(wrong.mean()), tile, edges, worst)


def worst_tile(wrong: Mask | npt.NDArray[np.int32]) -> tuple[float, tuple[int, int]]:
    """Return the largest share of wrong pixels in a tile, at any place, and the tile's corner.

    With numbers in the place of a mask: the largest mean.
    """
    sums = np.zeros((wrong.shape[0] + 1, wrong.shape[1] + 1), np.int32)
    np.cumsum(wrong, axis=0, out=sums[1:, 1:])
    np.cumsum(sums[1:, 1:], axis=1, out=sums[1:, 1:])
    rows = sums[TILE:] - sums[:-TILE]
    counts = rows[:, TILE:] - rows[:, :-TILE]
    row, column = divmod(int(counts.argmax()), counts.shape[1])
    return float(counts[row, column]) / TILE**2, (row, column)


def tile_means(plane: Floats) -> Floats:
    """Return a plane in which each pixel has the mean of its tile."""
    rows, columns = (np.arange(0, size, TILE) for size in plane.shape)
    sums = np.add.reduceat(np.add.reduceat(plane, rows, axis=0), columns, axis=1)
    tall = np.diff(np.append(rows, plane.shape[0]))
    wide = np.diff(np.append(columns, plane.shape[1]))
    means = sums / np.outer(tall, wide)
    spread: Floats = means.repeat(tall, axis=0).repeat(wide, axis=1).astype(np.float32)
    return spread


def _edges(picture: Image, band: Band) -> float:
    """Return what part of the samples' effect is missing, from 0 to 1.

    Samples that stand elsewhere, or are drawn by lot, differ from ours to both sides of their
    effect, so that only what lies along it counts.
    """
    effect = band.smooth - band.plain
    got = np.clip(picture.reshape(-1, 3)[band.pixels], 0, 1) - band.plain
    return max(0.0, 1 - float((got * effect).sum()) / float((effect**2).sum()))
