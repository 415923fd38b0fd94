"""The inspector's wait: from a pixel that is chosen to its table, in the kernel."""

from __future__ import annotations

import statistics
import time
from pathlib import Path
from typing import Any

from grader.lab.inspector import widget
from grader.lab.inspector.looking import Looking

ROUNDS = 15
SIZE = (320, 180)
SCENES = (0, 4, 3)  # the smallest, the one with most mirrors, a thousand spheres
GOAL = 0.15  # seconds, the browser's part included


def measure(core: Path) -> dict[int, float]:
    """Return the median seconds by scene, for the C files of a folder.

    The pixels go through the picture from corner to corner.
    """
    found = {}
    for scene in SCENES:
        looking = Looking(core, scene, SIZE, {})
        try:
            made = widget.make(looking, looking.look(0, 0))
            found[scene] = statistics.median(_wait(made, k) for k in range(1, ROUNDS + 1))
        finally:
            looking.probe.close()
    return found


def _wait(made: Any, k: int) -> float:
    start = time.perf_counter()
    made.pixel = [SIZE[0] * k // (ROUNDS + 1), SIZE[1] * k // (ROUNDS + 1)]
    return time.perf_counter() - start


def text(found: dict[int, float]) -> str:
    """Return a line for each scene."""
    lines = [
        f"  scene {scene:<12} {1000 * seconds:6.0f} ms   goal {1000 * GOAL:.0f} ms"
        f"   {'met' if seconds <= GOAL else 'missed'}"
        for scene, seconds in found.items()
    ]
    return "\n".join(["In the inspector, from a pixel to its table (wall time)", *lines])
