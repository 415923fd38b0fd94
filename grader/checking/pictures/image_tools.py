"""scikit-image, with which a wrong picture is explained: a right one never loads it.

It takes a third of a second to load, so what uses it imports it in its functions. Where it is
missing, in an environment made for an older version, less is told and shown.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from grader.checking.pictures.measure import Floats
from grader.checking.shapes import Image

WINDOW = 7  # pixels a side


@cache
def are_there() -> bool:
    """Say whether scikit-image can be used. Loads it."""
    try:
        from skimage import measure, metrics, morphology

        return all(
            callable(each)
            for each in (measure.label, metrics.structural_similarity, morphology.dilation)
        )
    except ImportError:
        return False


def similarity(got: Image, expected: Image) -> Floats | None:
    """Return how alike two pictures are around each pixel, by SSIM: 1 is alike, 0 and below is not.

    Colours of both are 0 to 1. Edges and shades in a window count more than the colour itself.
    None of tiny pictures, or without scikit-image.

    References: Wang, Bovik, Sheikh, Simoncelli, "Image quality assessment: from error visibility to
    structural similarity", 2004.
    """
    if min(got.shape[:2]) < WINDOW or not are_there():
        return None
    from skimage.metrics import structural_similarity

    _, found = structural_similarity(
        expected, got, win_size=WINDOW, data_range=1, channel_axis=2, full=True
    )
    return np.asarray(found.mean(axis=2), np.float32)
