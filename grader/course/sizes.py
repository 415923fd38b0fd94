"""The sizes of the pictures that a submission draws, in pixels (width, height): each is a build."""

from __future__ import annotations

Size = tuple[int, int]

UNIT: Size = (96, 64)  # of the build for functions: what the expected data was made for
PICTURE: Size = (320, 180)
DRAWN: tuple[Size, ...] = (PICTURE, UNIT)  # TP1's functions draw at both


def sizes_for(tp: int | None) -> tuple[Size, ...]:
    """Return the sizes that the checks of a TP (None: of all) draw at.

    Only TP1's are run at both; the data of the others was made for one.
    """
    return DRAWN if tp in (None, 1) else (UNIT,)
