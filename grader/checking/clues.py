"""What all the wrong answers of a batch have in common: a clue that is told beside the first one.

A clue is given only when it holds for every answer that is wrong, and for enough of them. It says
what was seen, and never what to write. The question that is asked follows it: see `question`.
"""

from __future__ import annotations

import itertools
from math import pi
from typing import Any

import numpy as np
import numpy.typing as npt

from grader.checking.describe import number, value
from grader.course.message import Message
from grader.course.texts import Texts

Array = npt.NDArray[Any]

FEWEST = 3  # wrong answers, or components of them, in which a pattern is no chance
RATIO = 2e-4  # by which the ratios of the components may differ, relative
SMALL = 1e-3  # of a component: it tells nothing
ROUNDING = 1e-6
NEAR_ONE = 0.05  # a factor nearer to 1 is a constant that is not quite right
# Factors that have a name; their inverses have one too.
_FACTORS = {
    "pi": pi,
    "2 pi": 2 * pi,
    "4 pi": 4 * pi,
    "8 pi": 8 * pi,
    "pi²": pi**2,
    "180 / pi": 180 / pi,
    **{str(each): float(each) for each in (2, 3, 4, 8, 9, 10, 16, 100, 255, 256)},
}
# What the stack is filled with (build/shim/paint.c): no computation gives it.
_PAINT = b"\xfe" * 4
_FLOAT, _INT = float(np.frombuffer(_PAINT, "f4")[0]), int(np.frombuffer(_PAINT, "i4")[0])
# What is written for pi: by how much it is wrong.
_PIS = (3.14, 3.1, 3.0, 22 / 7)


def of(got: Array, right: Array, wrong: Array, tolerance: float = 0.0) -> Message | None:
    """Return what the wrong answers have in common; None when nothing is found.

    Parameters
    ----------
    got, right
        what came and what is expected, one row for each call; numbers or bools, shape (calls,) or
        (calls, components)
    wrong
        which calls are wrong, bool, shape (calls,)
    tolerance
        within which answers are right, relative to rows larger than 1
    """
    came, expected = (np.asarray(each).reshape(len(wrong), -1) for each in (got, right))
    if came.shape != expected.shape or came.dtype.kind not in "fiub":
        return None
    if clue := _unset(came[wrong]) or _constant(came, expected):
        return clue
    if came.dtype.kind == "b":
        return None
    a, b = (each[wrong].astype(np.float64) for each in (came, expected))
    if np.isnan(a).any(axis=1).all():
        return Message("clue.nan")
    if not len(a) or not np.isfinite(a).all() or not np.isfinite(b).all():
        return None
    room = tolerance * np.maximum(1.0, np.abs(b).max(axis=1, keepdims=True)) + ROUNDING
    # Those that a single call may show come first.
    looks = [_limited]
    if len(a) >= FEWEST:
        looks += [_factor, _signs, _exchanged, _offset, _grey, _scaled]
    return next(filter(None, (look(a, b, room) for look in looks)), None)


def deeper(depths: Array, wrong: Array) -> Message | None:
    """Return that the calls are wrong from a depth on, and right up to it."""
    if wrong.sum() < FEWEST or wrong.all():
        return None
    first = depths[wrong].min()
    return Message("clue.depth", {"depth": int(first)}) if first > depths[~wrong].max() else None


def question(message: Message | None, check: str, texts: Texts, level: int = 1) -> str:
    """Return what to ask about a wrong answer, by the part that is wrong and what it looks like.

    "" when the check's own question will do; at a higher level, the help that goes with it.
    """
    if message is None:
        return ""
    part = message.values.get("part", "")
    whole, short = check.partition(".")[2], check.rpartition(".")[2]
    names = [f"{whole}.{part}", f"{short}.{part}"] if part else []
    values = {key: each for one in message.then for key, each in one.values.items()}
    for name in (*names, *(each.key for each in message.then)):
        keys = [f"ask.more.{name}"] * (level > 1) + [f"ask.{name}"]
        if found := next(filter(texts.get, keys), ""):
            return texts.say(found, **values)
    return ""


def _unset(came: Array) -> Message | None:
    """Find answers made of what the stack is filled with, or of little more than that."""
    paint = _FLOAT if came.dtype.kind == "f" else _INT
    if came.dtype.kind == "u":
        paint %= 1 << 8 * came.dtype.itemsize
    is_paint = np.abs(came.astype(np.float64) - paint) <= RATIO * abs(paint)
    return Message("clue.unset") if len(came) and is_paint.any(axis=1).all() else None


def _constant(came: Array, expected: Array) -> Message | None:
    """Find one answer for all the calls."""
    if len(came) < FEWEST or not (came == came[0]).all() or (expected == expected[0]).all():
        return None
    first = came[0] if came.shape[1] > 1 else came[0, 0]
    return Message("clue.constant", {"value": value(first)})


def _factor(a: Array, b: Array, room: Array) -> Message | None:
    """Find a constant between all the components."""
    ratio = _ratio(a, b)
    if ratio is None:
        return None
    if abs(ratio + 1) <= RATIO:
        return Message("clue.opposite")
    off = [each for each in _PIS for k in (1, -1, 2, -2) if _is(ratio, (each / pi) ** k)]
    if off:
        return Message("clue.pi", {"pi": number(off[0], 3)})
    if abs(ratio - 1) < NEAR_ONE:
        return Message("clue.constants", {"factor": number(ratio, 6)})
    return Message("clue.factor", {"factor": _named(ratio)})


def _ratio(a: Array, b: Array) -> float | None:
    """Return a over b when it is the same in all components; None when it is not."""
    squares = float((b * b).sum())
    if (np.abs(b) > SMALL).sum() < FEWEST:
        return None
    ratio = float((a * b).sum()) / squares
    alike = np.abs(a - ratio * b) <= RATIO * np.abs(a) + ROUNDING
    is_other = abs(ratio) > RATIO and abs(ratio - 1) > 2 * RATIO
    return ratio if alike.all() and is_other else None


def _signs(a: Array, b: Array, room: Array) -> Message | None:
    """Find components that have the opposite sign, or are zero, in all the answers."""
    if a.shape[1] != 3:
        return None
    turned, lost = [], []
    for k, name in enumerate("xyz"):
        own, other, slack = a[:, k], b[:, k], room[:, 0]
        if (np.abs(own - other) <= slack).all():
            continue
        if (np.abs(own + other) <= slack).all():
            turned.append(name)
        elif (own == 0).all():
            lost.append(name)
        else:
            return None
    if bool(turned) == bool(lost):
        return None
    if len(lost) == 3:
        return Message("clue.zero")
    key = "clue.sign" if turned else "clue.dropped"
    return Message(key, {"names": ", ".join(turned or lost)})


def _exchanged(a: Array, b: Array, room: Array) -> Message | None:
    """Find axes, or channels, that have changed places."""
    if a.shape[1] != 3:
        return None
    for order in itertools.permutations(range(3)):
        moved = b[:, list(order)]
        if order != (0, 1, 2) and (np.abs(a - moved) <= room).all():
            names = ", ".join("xyz"[k] for k in order)
            return Message("clue.exchanged", {"names": f"({names})"})
    return None


def _limited(a: Array, b: Array, room: Array) -> Message | None:
    """Find answers that are brought between 0 and 1."""
    limited = np.clip(b, 0, 1)
    if ((limited != b) & (a == limited)).sum() < FEWEST:
        return None
    return Message("clue.limited") if (np.abs(a - limited) <= room).all() else None


def _offset(a: Array, b: Array, room: Array) -> Message | None:
    """Find the same amount too much in all the answers."""
    more = a - b
    typical = np.median(more, axis=0)
    rounding = RATIO * np.abs(b) + ROUNDING
    if (np.abs(more - typical) > rounding).any() or np.abs(typical).max() < SMALL:
        return None
    if (np.ptp(b, axis=0) < SMALL).all():
        return None
    shown = typical if len(typical) > 1 else typical[0]
    return Message("clue.offset", {"offset": value(shown)})


def _grey(a: Array, b: Array, room: Array) -> Message | None:
    """Find colours whose channels have become one."""
    if a.shape[1] != 3 or (np.ptp(a, axis=1) > room[:, 0]).any():
        return None
    return Message("clue.grey") if (np.ptp(b, axis=1) > SMALL).all() else None


def _scaled(a: Array, b: Array, room: Array) -> Message | None:
    """Find vectors of the right direction, or colours of the right hue, by a factor that varies."""
    squares = (b * b).sum(axis=1, keepdims=True)
    if a.shape[1] != 3 or (squares < SMALL).any() or (np.ptp(b, axis=1) < SMALL).all():
        return None
    factors = (a * b).sum(axis=1, keepdims=True) / squares
    fits = np.abs(a - factors * b) <= room * np.maximum(1.0, np.abs(factors))
    if not fits.all() or (factors <= SMALL).any() or np.ptp(factors) < SMALL:
        return None
    is_unit = np.abs(squares - 1).max() < SMALL
    return Message("clue.length" if is_unit else "clue.varying")


def _is(ratio: float, other: float) -> bool:
    return abs(ratio / other - 1) <= RATIO / 4


def _named(ratio: float) -> str:
    """Return a factor as one writes it in a formula."""
    sign, size = ("-" if ratio < 0 else ""), abs(ratio)
    for name, factor in _FACTORS.items():
        if abs(size / factor - 1) <= RATIO:
            return f"{sign}{name}"
        if abs(size * factor - 1) <= RATIO:
            return f"{sign}1 / {name}" if " / " not in name else f"{sign}pi / 180"
    return number(ratio)
