"""The most alike pairs that `make alike` has left in the folder of results: reads JSON only."""

from __future__ import annotations

import json
from collections.abc import Collection
from pathlib import Path
from typing import Any

NAME, PAGE = "alike.json", "alike.html"
MOST = 10  # pairs


def read(out: Path, graded: Collection[str], names: bool) -> list[dict[str, Any]]:
    """Return the pairs of which one at least is among the graded; none where nobody has looked.

    Without `names` they have their pseudonyms, which are those of the class page.
    """
    try:
        pairs = json.loads((out / NAME).read_text(encoding="utf-8"))["pairs"]
        label = "name" if names else "pseudonym"
        return [
            {
                **each,
                "one": str(each["one"][label]),
                "other": str(each["other"][label]),
            }
            for each in pairs
            if each["one"]["name"] in graded
        ]
    except (OSError, ValueError, KeyError, TypeError):
        return []
