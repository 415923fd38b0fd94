"""Numbers of the given headers, which nothing else says again: RAY_TMAX, SPHERE, EPSILON.

A built library has them too (`core.constants`); they are read here where none is at hand.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache

from grader.intake import originals
from grader.setup import c_text

_SAID = re.compile(r"(?:#define (\w+)|[{,] *(\w+) =) (\d+(?:\.\d*)?(?:e-?\d+)?)f?\b")
_KINDS = re.compile(r"enum \{ (SPHERE [^}]*)\}")


def header_number(name: str) -> float:
    """Return a macro, or a constant of an enum. Raises KeyError, OriginalsError."""
    return _numbers()[name]


@cache
def kinds() -> Mapping[int, str]:
    """Return the types of objects by their numbers: "SPHERE", "PLANE" ... Raises OriginalsError."""
    names = re.findall(r"(\w+) =", "".join(_KINDS.findall(_headers())))
    return {int(header_number(name)): name for name in names}


@cache
def _numbers() -> dict[str, float]:
    found = _SAID.findall(_headers())
    return {macro or constant: float(value) for macro, constant, value in found}


@cache
def _headers() -> str:
    files = originals.read(in_place=False)
    texts = (files[name].decode("latin-1") for name in sorted(files) if name.endswith(".h"))
    return c_text.without_comments("\n".join(texts))
