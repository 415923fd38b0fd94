"""The functions of the given headers, with what is written above each."""

from __future__ import annotations

import re
from functools import cache

from grader.intake import originals

# A comment, or none, then a prototype or the head of a `static inline` function.
_FUNCTION = re.compile(
    r"(?:/\*(?P<comment>(?:(?!\*/).)*)\*/\n)?"
    r"(?P<head>(?:static inline )?\w[\w ]*[ *](?P<name>\w+)\([^;{}()]*\))\s*[;{]",
    re.DOTALL,
)
_HEADERS = ("vector.h", "ray.h", "scene.h", "exercises.h")


@cache
def contracts() -> dict[str, str]:
    """Return the prototype and the comment of every function, by its name."""
    found: dict[str, str] = {}
    files = originals.read(in_place=True)
    for name in _HEADERS:
        for match in _FUNCTION.finditer(files[name].decode()):
            comment = re.sub(r"(?m)^ \* ?", "", match["comment"] or "").strip()
            head = " ".join(match["head"].split()).removeprefix("static inline ")
            if " " in head.split("(")[0]:
                found[match["name"]] = f"{head};\n\n{comment}".strip()
    return found
