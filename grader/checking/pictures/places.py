"""Where a picture is wrong: the places in which wrong pixels lie together, told and boxed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from grader.checking.pictures import image_tools
from grader.checking.pictures.regions import Maps, on_thing
from grader.checking.pictures.views import Box
from grader.checking.shapes import Mask
from grader.course.message import Message

APART = 5  # pixels: specks that lie nearer to one another are one place
FEWEST = 8  # wrong pixels of a place
MOST_TOLD = 3
MOST_WRONG = 0.5  # of the picture: above, what is wrong has no place
ALL_OVER = 0.6  # of the picture, in a place's box
_ROWS = ("bottom", "middle", "top")  # thirds
_COLUMNS = ("left", "center", "right")


@dataclass(frozen=True)
class Place:
    """Wrong pixels that lie together.

    `box` is the first row and column, and those after the last; row 0 is at the bottom.
    """

    box: Box
    count: int  # of its wrong pixels
    words: Message


def find(wrong: Mask, maps: Maps | None = None) -> list[Place]:
    """Return the places in which a picture is wrong, the largest first.

    None when most of the picture is wrong, or scikit-image is missing. `maps` tells what is seen
    there.
    """
    if not wrong.any() or wrong.mean() > MOST_WRONG or not image_tools.are_there():
        return []
    from skimage.measure import label, regionprops
    from skimage.morphology import closing

    joined = label(closing(wrong, np.ones((APART, APART))))
    found = [each for each in regionprops(joined * wrong) if each.area >= FEWEST]
    found.sort(key=lambda each: -each.area)
    return [_place(each, wrong.shape[0], wrong.shape[1], maps) for each in found]


def told(places: Sequence[Place]) -> Message | None:
    """Return the sentence on the largest places; None when there is none."""
    if not places:
        return None
    shown = [each.words for each in places[:MOST_TOLD]]
    key = str(len(shown)) if len(places) == len(shown) else "more"
    values: dict[str, object] = dict(zip(("first", "second", "third"), shown, strict=False))
    return Message(f"places.{key}", {**values, "count": len(places)})


def _place(region: Any, height: int, width: int, maps: Maps | None) -> Place:
    """Return a region as a place: where it is, what is seen there, how many pixels it has."""
    bottom, left, top, right = map(int, region.bbox)
    if (top - bottom) * (right - left) > ALL_OVER * height * width:
        name = "all_over"
    else:
        row, column = region.centroid
        name = f"{_ROWS[int(3 * row / height)]}_{_COLUMNS[int(3 * column / width)]}"
    where = Message(f"place.{name}")
    if maps is not None:
        seen = np.bincount(maps.thing[tuple(region.coords.T)])
        thing = maps.things[int(seen.argmax())]
        where = Message("place.on_thing", {"where": where, "thing": on_thing(thing)})
    count = int(region.area)
    words = Message("place.counted", {"where": where, "count": count})
    return Place((bottom, left, top, right), count, words)
