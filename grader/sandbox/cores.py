"""How many programs this process may run side by side."""

from __future__ import annotations

import os


def usable() -> int:
    """Return the number of processors that this process may use: `taskset` leaves it fewer."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # no Linux
        return os.cpu_count() or 1
