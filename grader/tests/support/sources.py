"""Sources that a compiler never comes to the end of."""

from __future__ import annotations


def _endless() -> str:
    """Return macros that expand to nothing, ten times as often at each level: time, no memory."""
    levels = [f"#define E{k} " + " ".join([f"E{k - 1}"] * 10) for k in range(1, 13)]
    return "\n".join(["#define E0", *levels, "E12", "int x;", ""])


ENDLESS = _endless()
