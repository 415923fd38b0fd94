"""Draws what the known mistakes give, for grader/checking/pictures/suspects.py."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from grader.authoring.expected.pictures.calibration import limits
from grader.authoring.expected.pictures.program import RenderError
from grader.authoring.expected.pictures.sources import by_mistake
from grader.authoring.specimens import mistakes
from grader.authoring.specimens.mistakes import Mistake
from grader.checking.pictures import expected_files
from grader.checking.pictures.candidates import encode, name_of, shown_in
from grader.checking.pictures.expected_files import Expected
from grader.checking.pictures.measure import measure, outside
from grader.checking.pictures.plan import ExpectedPicture, judged
from grader.checking.shapes import Image
from grader.course import scenes
from grader.files import content_key

# The stages in which the mistakes of a TP show first; those of bonus shapes in their own scenes.
STAGES: Mapping[int, tuple[str, ...]] = {
    2: ("flat",),
    3: ("blinn_phong",),
    4: ("shadows", "mirror"),
    5: ("fresnel", "smooth", "glass"),
}


def shows_first(mistake: Mistake, picture: ExpectedPicture) -> bool:
    """Say whether a mistake is kept with a picture, if it shows there."""
    if picture.stage in STAGES.get(mistake.tp, ()):
        return True
    own = (number for number, scene in scenes.load().items() if mistake.exercise in scene.shows)
    return picture.stage == "shadows" and picture.scene == next(own, None)


def files(folder: Path, picture: ExpectedPicture) -> tuple[dict[str, bytes], Mapping[str, Any]]:
    """Return the file of the mistakes that show in a picture of a folder of expected data."""
    expected = expected_files.read(folder, picture)
    drawn = {}
    for mistake in mistakes.load():
        if shows_first(mistake, picture):
            got = _drawn(mistake, expected)
            if got is not None:
                drawn[mistake.id] = got
    if not drawn:
        return {}, {}
    right = expected_files.read_png(folder, picture)
    return {name_of(picture.name): encode(drawn, right, expected.envelope)}, {}


def is_of(folder: Path, mistake: Mistake, picture: ExpectedPicture) -> bool:
    """Say whether a mistake is, or should be, in the file of those that show in a picture."""
    if not shows_first(mistake, picture):
        return False
    kept = shown_in(folder, picture.name)
    return mistake.id in kept or _drawn(mistake, expected_files.read(folder, picture)) is not None


def _drawn(mistake: Mistake, expected: Expected) -> Image | None:
    """Return a mistake's picture; None where it is right, or where there is none."""
    with contextlib.suppress(RenderError):  # of one that crashes there is no picture
        got = by_mistake(mistake).draw(expected.picture)
        if _is_wrong(got, expected):
            return got
    return None


def _is_wrong(got: Image, expected: Expected) -> bool:
    if not np.isfinite(got).all():
        return True
    error = outside(got, expected.envelope)
    return measure(got, expected.envelope, error).exceeds(expected.limits) > 1


def fingerprints() -> dict[str, str]:
    """Return what stands for each mistake that pictures are kept of, and for what shows of it."""
    kept = {each: [one for one in judged() if shows_first(each, one)] for each in mistakes.load()}
    return {
        mistake.id: content_key(mistake.written, [_allowed(each) for each in pictures])
        for mistake, pictures in kept.items()
        if pictures
    }


def _allowed(picture: ExpectedPicture) -> list[float]:
    return [row["limit"] for row in limits(picture).values()]
