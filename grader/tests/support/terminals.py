"""What a terminal of a test has been told."""

from __future__ import annotations

import contextlib
import os


def read_all(reading: int) -> bytes:
    """Return all that the other end of a terminal has written, once it is closed; close this one.

    A terminal gives what it has, bit by bit.
    """
    said = b""
    with contextlib.suppress(OSError):  # nothing more can come
        while more := os.read(reading, 9999):
            said += more
    os.close(reading)
    return said
