"""The files of expected pictures, in the folder pictures/ of the expected data.

    scene4.shadows.npz  what is accepted: `low` and `range`, and the `calm` pixels
    scene4.shadows.png  the reference's own picture, for people
    scene4.maps.npz     what stands where: objects, distances, normals, lights, regions
    scene4.light.npz    the light at each first hit: kd, n.l, Fresnel, what each light adds

`manifest.json` has the sha256 and the limits of each. Colours are in units of 1/4080 (a 16th of a
level of the picture's file), as differences along the rows, their low bytes before their high ones:
so they take little room.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image as Pillow

from grader.checking.expected_data import Array, ExpectedError, arrays_of, content_of, rules_of
from grader.checking.npz import Arrays
from grader.checking.pictures.measure import Band, Envelope, Floats, PictureLimits
from grader.checking.pictures.plan import ExpectedPicture
from grader.checking.shapes import Image

FOLDER = "pictures"  # in the folder of expected data
UNITS = 4080
BRIGHTEST = 16.0  # what shade gives, in the light's maps
FARTHEST = 1000.0  # scene units
LOG_UNITS = 6000


@dataclass(frozen=True)
class Expected:
    """An expected picture: what is accepted, and up to which measures."""

    picture: ExpectedPicture
    envelope: Envelope
    limits: PictureLimits


def are_there(folder: Path) -> bool:
    """Say whether a folder of expected data has expected pictures."""
    return (folder / FOLDER).is_dir()


def read(folder: Path, picture: ExpectedPicture) -> Expected:
    """Read what is accepted. Raises ExpectedError, naming the file and the cure."""
    path = folder / FOLDER / f"{picture.name}.npz"
    rules = rules_of(path)
    arrays = arrays_of(path, rules)
    try:
        limits = PictureLimits(**{k: v["limit"] for k, v in rules["limits"].items()})
        low, width = unpacked(arrays["low"]), unpacked(arrays["range"])
        shape = low.shape[1:]
        calm = np.unpackbits(arrays["calm"], count=shape[0] * shape[1]).reshape(shape).astype(bool)
        envelope = Envelope(
            low=_colors(low),
            high=_colors(low + width),
            calm=calm,
            band=_band(arrays) if "band" in arrays else None,
            is_flat=picture.stage == "flat",
            by_means=picture.stage == "glass",
        )
        return Expected(picture, envelope, limits)
    except (KeyError, TypeError, ValueError) as error:
        raise ExpectedError(path, error) from error


def read_png(folder: Path, picture: ExpectedPicture) -> Image:
    """Return the reference's own picture, 0 to 1, row 0 at the bottom. Raises ExpectedError."""
    return np.ascontiguousarray(_pixels(folder, f"{picture.name}.png")[::-1])


def read_texels(folder: Path) -> Image:
    """Return the texture of the pictures, 0 to 1, row 0 at the top. Raises ExpectedError."""
    return _pixels(folder, "texture.png")


def _pixels(folder: Path, name: str) -> Image:
    path = folder / FOLDER / name
    with Pillow.open(io.BytesIO(content_of(path, rules_of(path)))) as file:
        return np.asarray(file.convert("RGB"), np.float32) / np.float32(255)


def read_arrays(folder: Path, name: str) -> Arrays:
    """Return the arrays of a file. Raises ExpectedError."""
    path = folder / FOLDER / name
    return arrays_of(path, rules_of(path))


def packed(values: Array) -> Array:
    """Return uint16 values, shape (..., width), so that they take little room when deflated."""
    steps = np.diff(values, axis=-1, prepend=np.uint16(0)).astype(np.uint16)
    return np.stack([steps & 255, steps >> 8]).astype(np.uint8)


def unpacked(parts: Array) -> Array:
    """Return the values that `packed` was given."""
    steps = parts[0] + (parts[1].astype(np.uint16) << 8)
    values: Array = np.cumsum(steps, axis=-1, dtype=np.uint16)
    return values


def distances_packed(t: Array) -> Array:
    """Return distances along rays, as logarithms that `distances` reads to 1/5000."""
    return packed(np.rint(np.log2(1 + np.minimum(t, FARTHEST)) * LOG_UNITS).astype(np.uint16))


def distances(parts: Array) -> Array:
    """Return the distances that `distances_packed` was given; beyond FARTHEST, that."""
    found: Array = np.exp2(unpacked(parts) / LOG_UNITS) - 1
    return found


def colors(parts: Array) -> Floats:
    """Return the colours of the light's maps, shape (..., 3, height, width)."""
    return _colors(unpacked(parts))


def _band(arrays: Mapping[str, Array]) -> Band:
    smooth, plain = (_colors(arrays[name]) for name in ("smooth", "plain"))
    return Band(arrays["band"].astype(np.intp), smooth, plain)


def _colors(units: Array) -> Floats:
    """Return colours, 0 to 1."""
    return units.astype(np.float32) * np.float32(1 / UNITS)
