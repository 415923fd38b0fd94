"""The limits of what is measured, from what right programs reach: calibration.json."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

from grader.checking.pictures.plan import ExpectedPicture

TABLE = Path(__file__).with_name("calibration.json")
PATTERN_FACTOR = 2.5  # many edges, which readings draw differently
MARGIN = 2.0  # no right program may come nearer to a limit than that
# Limits are so many times what the programs reach that set them: others reach a bit more.
ROOM = 2.5
# Accepted in the place of other stages only: among hundreds of spheres that overlap, roundings grow
# from bounce to bounce until right programs share few pixels. Measured by tile: 0.28 with another
# sphere test, 0.39 with an offset along the normal.
CHAOTIC = (ExpectedPicture(3, "fresnel"),)
CHAOTIC_TILE = 0.8
HIGHEST = 3.0  # times the least limit: beyond, mistakes would pass


def defaults(picture: ExpectedPicture) -> dict[str, float]:
    """Return the least limit of each measure."""
    if picture.stage == "glass":
        return {"share": 0.02, "tile": 0.08}
    if picture.is_smooth:
        return {"share": 0.0025, "tile": 0.2, "edges": 0.45}  # without samples: 1
    least = {"share": 0.001 if picture.stage == "flat" else 0.0005, "tile": 0.12}
    if picture in CHAOTIC:
        least["tile"] = CHAOTIC_TILE
    factor = PATTERN_FACTOR if picture.rules.patterned else 1.0
    return {name: value * factor for name, value in least.items()}


def limits(picture: ExpectedPicture) -> dict[str, dict[str, Any]]:
    """Return each limit, the worst that a right program reached, their ratio, and the reason."""
    reached = _table().get(picture.name, {})
    found = {}
    for name, least in defaults(picture).items():
        worst = float(reached.get(name, {}).get("worst", 0.0))
        limit = max(least, ROOM * worst)
        found[name] = {
            "limit": round(limit, 6),
            "worst": round(worst, 6),
            "margin": round(limit / worst, 1) if worst else None,
            "reason": f"{ROOM:g} times what the variant {reached[name]['variant']} reaches"
            if limit > least
            else "the least: weaker mistakes do not show",
        }
    return found


@cache
def _table() -> Mapping[str, Any]:
    if not TABLE.is_file():
        return {}
    return dict(json.loads(TABLE.read_text(encoding="utf-8")))


def forget() -> None:
    """Read the table again when it is next asked for."""
    _table.cache_clear()
