"""What may be wrong with a picture as a whole: black, upside down, too bright, of another stage."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from grader.checking.pictures.measure import Envelope, Floats, outside
from grader.checking.shapes import Image, Mask, in_every_channel
from grader.course.message import Message

FAR = 8 / 255  # a pixel outside by more is counted here
FEW = 0.02  # share of such pixels in a picture that is right but for one thing
BETTER = 4  # times fewer of them, for one thing to explain the others
BLACK = 1 / 255
GAMMA = 2.2
SCALE_RANGE = (0.08, 0.92)  # colours whose ratio can be told
SCALE_LEAST = 0.04
DARKEST = 0.05
UNLIT = "picture.unlit"
SCALE_SLACK = 0.02
LEAST_KNOWN = 100  # colours to find a factor from

Change = Callable[[Image], Image]
# How a picture is put back.
_STEPS = {"right": (0, -1), "left": (0, 1), "up": (-1, 0), "down": (1, 0)}
_ORDERS = {
    "rb": (2, 1, 0),
    "rg": (1, 0, 2),
    "gb": (0, 2, 1),
    "turned": (1, 2, 0),
    "back": (2, 0, 1),
}


def is_plain(picture: Image) -> bool:
    """Say whether a picture has one colour only."""
    seen = np.clip(picture, 0, 1)
    return bool((np.ptp(seen.reshape(-1, 3), axis=0) < BLACK).all())


def plain(picture: Image) -> Message:
    """Name the colour of a picture that has only one."""
    color = np.clip(picture[0, 0], 0, 1)
    if color.max() < BLACK:
        return Message("picture.black")
    return Message("picture.one_color", {"color": ", ".join(f"{each:.2f}" for each in color)})


def not_finite(picture: Image) -> Message | None:
    """Say where a picture has something else than numbers."""
    broken = ~in_every_channel(np.isfinite(picture))
    if not broken.any():
        return None
    j, i = (int(each) for each in np.argwhere(broken)[0])
    return Message("picture.not_finite", {"count": int(broken.sum()), "i": i, "j": j})


def explain(got: Image, expected: Image, envelope: Envelope, objects: Mask) -> Message | None:
    """Return the one thing that makes a picture wrong everywhere, if there is one.

    `objects` is where the picture shows something else than the sky.
    """
    before = _share_far(got, envelope)
    for key, change in _changes():
        after = _share_far(change(got), envelope)
        if after < FEW and after * BETTER < before:
            return Message(key)
    return _scaled(got, expected, objects)


def turned(got: Image, expected: Image, tolerance: float) -> str:
    """Return the key of what puts a picture of any size right at every pixel, "" for nothing."""
    for key, change in _changes():
        if (np.abs(change(got) - expected) <= tolerance).all():
            return key
    return ""


def _share_far(picture: Image, envelope: Envelope) -> float:
    return float((outside(picture, envelope) > FAR).mean())


def _changes() -> Iterator[tuple[str, Change]]:
    """Yield what a student may have turned round, and what turns it back."""
    yield "picture.upside_down", np.flipud
    yield "picture.mirrored", np.fliplr
    yield "picture.half_turn", partial(np.flip, axis=(0, 1))
    for name, order in _ORDERS.items():
        yield f"picture.channels_{name}", partial(np.take, indices=order, axis=2)
    yield "picture.gamma_applied", partial(_powered, gamma=GAMMA)
    yield "picture.gamma_removed", partial(_powered, gamma=1 / GAMMA)
    for name, step in _STEPS.items():
        yield f"picture.shifted_{name}", partial(np.roll, shift=step, axis=(0, 1))


def _powered(picture: Image, gamma: float) -> Image:
    with np.errstate(over="ignore"):  # what is so bright stays too bright
        return np.clip(picture, 0, None) ** np.float32(gamma)


def _scaled(got: Image, expected: Image, objects: Mask) -> Message | None:
    """Say by how much everything is too bright or too dark."""
    low, high = SCALE_RANGE
    known = (expected > low) & (expected < high) & objects[:, :, None]
    factor = typical_factor(got, expected, known)
    black = objects & (expected.max(axis=2) < BLACK)
    if factor is None or abs(factor - 1) < SCALE_LEAST or _is_lighted(got[black]):
        return None
    return scale_verdict("picture.all_", factor)


def _is_lighted(colors: Floats) -> bool:
    """Say whether what should be black is not: no factor makes it so."""
    return bool((colors > SCALE_LEAST).any(axis=1).mean() > FEW) if len(colors) else False


def typical_factor(
    got: Image, expected: Image, known: Mask, exceptions: float = 2 * FEW
) -> float | None:
    """Return the factor by which the known colours differ, but for few exceptions; or None."""
    seen, right = np.clip(got[known], 0, 1), expected[known]
    open_ended = seen < SCALE_RANGE[1]
    if open_ended.sum() < LEAST_KNOWN:
        return None
    factor = float(np.median(seen[open_ended] / right[open_ended]))
    off = np.abs(seen - np.minimum(factor * right, 1)) > SCALE_SLACK * max(1.0, factor)
    return factor if off.mean() < exceptions else None


def scale_verdict(start: str, factor: float) -> Message:
    """Return the sentence on a factor, told as a number above 1; its key begins with `start`."""
    if factor < DARKEST:
        return Message(UNLIT)
    if factor < 1:
        return Message(f"{start}dark", {"factor": number(1 / factor)})
    return Message(f"{start}bright", {"factor": number(factor)})


def number(value: float) -> Message:
    """Return a number to be told in the decimals of the language."""
    whole, _, part = f"{value:.3g}".partition(".")
    if not part:
        return Message("number.whole", {"whole": whole})
    return Message("number.decimal", {"whole": whole, "part": part})
