"""Known mistakes that a wrong picture may come from: those whose own picture is nearly the same.

`scene0.flat.mistakes.npz` holds what the mistakes draw that show in scene0.flat: `ids`, the `means`
of their tiles, and by its number each picture, as levels away from the reference's own.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt

from grader.checking.npz import Arrays, archived
from grader.checking.pictures import expected_files, image_tools
from grader.checking.pictures.expected_files import Expected
from grader.checking.pictures.measure import TILE, Envelope, tile_means
from grader.checking.pictures.neighbours import Surroundings
from grader.checking.shapes import Image, Mask

SLACK = 4  # levels by which colours may differ besides
# How far from a mistake's picture one may be, over how far it is from the right one.
NEARLY = 0.05
NEARLY_BY_MEANS = 0.3  # the same by the means of tiles, which tell at once what is far

Levels = npt.NDArray[np.int16]  # colours from 0 to 255, shape (height, width, 3)


def name_of(picture: str) -> str:
    """Return the name of the file that goes with a picture."""
    return f"{picture}.mistakes.npz"


def shown_in(folder: Path, picture: str) -> tuple[str, ...]:
    """Return the mistakes that show in a picture. Raises ExpectedError."""
    return tuple(json.loads(arrays["ids"].tobytes())) if (arrays := _read(folder, picture)) else ()


def near(folder: Path, expected: Expected, got: Image, only: Mask | None = None) -> tuple[str, ...]:
    """Return the mistakes that give nearly this picture, none where nothing is stored of them.

    None either without scikit-image. `only` is where the picture was judged (None: everywhere).
    Raises ExpectedError.
    """
    picture = expected.picture
    arrays = _read(folder, picture.name)
    if arrays is None or not image_tools.are_there():
        return ()
    envelope = expected.envelope
    seen, right = (
        _levels(each, envelope) for each in (got, expected_files.read_png(folder, picture))
    )
    slack = _slack(envelope)
    where = np.ones(seen.shape[:2], bool) if only is None else only
    around = Surroundings.of(seen)

    def apart(other: Levels) -> float:
        """Return the share of the pixels that are not the same, up to a pixel's place."""
        differs = Surroundings.of(other).excluding(seen, slack) | around.excluding(other, slack)
        return float(differs[where].mean())

    most = NEARLY * apart(right)
    ids = json.loads(arrays["ids"].tobytes())
    numbers = range(len(ids)) if only is not None else _near(seen, right, arrays["means"])
    return tuple(
        ids[number] for number in numbers if apart(_unpacked(arrays[str(number)], right)) < most
    )


def encode(drawn: Mapping[str, Image], right: Image, envelope: Envelope) -> bytes:
    """Return the content of a file: what each mistake draws, and the reference."""
    base = _levels(right, envelope)
    levels = {name: _levels(each, envelope) for name, each in drawn.items()}
    return archived(
        {
            "ids": np.frombuffer(json.dumps(list(drawn)).encode(), np.uint8),
            "means": np.array([_means(each) for each in levels.values()], np.uint8),
            **{str(k): _packed(each, base) for k, each in enumerate(levels.values())},
        }
    )


def _read(folder: Path, picture: str) -> Arrays | None:
    name = name_of(picture)
    return (
        expected_files.read_arrays(folder, name)
        if (folder / expected_files.FOLDER / name).is_file()
        else None
    )


def _levels(picture: Image, envelope: Envelope) -> Levels:
    """Return a picture in levels; of one drawn by lot, the means of its tiles."""
    known = np.clip(np.nan_to_num(picture, nan=0.0, posinf=1.0, neginf=0.0), 0, 1)
    if envelope.by_means:
        known = np.stack([tile_means(known[:, :, k]) for k in range(3)], axis=2)
    levels: Levels = np.rint(known * 255).astype(np.int16)
    return levels


def _slack(envelope: Envelope) -> Levels:
    """Return by how much a colour may differ at each pixel: as much as accepted readings do."""
    width = (envelope.high - envelope.low).max(axis=0)
    slack: Levels = SLACK + np.rint(width * 255).astype(np.int16)
    return slack[:, :, None]


def _near(seen: Levels, right: Levels, means: npt.NDArray[np.uint8]) -> Iterator[int]:
    """Yield the numbers of the pictures whose tiles are nearly the same."""
    own = _means(seen)
    most = NEARLY_BY_MEANS * float(np.abs(own - _means(right)).mean())
    for number, each in enumerate(means):
        # Stored means are rounded.
        if float(np.maximum(np.abs(own - each) - 1, 0).mean()) < most:
            yield number


def _means(levels: Levels) -> npt.NDArray[np.float32]:
    """Return the means of the tiles, shape (3, rows, columns)."""
    planes = levels.astype(np.float32).transpose(2, 0, 1)
    return np.stack([tile_means(plane)[::TILE, ::TILE] for plane in planes])


def _packed(levels: Levels, right: Levels) -> npt.NDArray[np.uint8]:
    """Return a picture so that it takes little room when deflated."""
    away = (levels - right).astype(np.uint8).transpose(2, 0, 1)
    return np.diff(away, axis=2, prepend=np.uint8(0))


def _unpacked(parts: npt.NDArray[np.uint8], right: Levels) -> Levels:
    away = np.cumsum(parts, axis=2, dtype=np.uint8).transpose(1, 2, 0)
    levels: Levels = (right + away) & 255
    return levels
