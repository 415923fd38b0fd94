"""The name that was meant, for the error of one that there is not."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def nearest(name: str, known: Iterable[str]) -> str:
    """Return the name that is most like one; "" where none is known."""
    return "".join(difflib.get_close_matches(name, [*known], 1, 0))
