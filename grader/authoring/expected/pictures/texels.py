"""The texture of the pictures: the course's, shrunk to several pixels for each texel."""

from __future__ import annotations

from functools import cache

import numpy as np
from PIL import Image as Pillow

from grader.authoring.drawings.texture import TEXTURE
from grader.checking.expected_data import Array

SIZE = (32, 16)


@cache
def texels() -> Array:
    """Return the texture, shape (16, 32, 3), 0 to 1."""
    with Pillow.open(TEXTURE) as file:
        small = file.convert("RGB").resize(SIZE, Pillow.Resampling.BOX)
    return np.asarray(small, np.float32) / np.float32(255)
