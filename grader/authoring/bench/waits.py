"""What a person waits for, and how long at most: a line for each wait."""

from __future__ import annotations

from collections.abc import Mapping


def text(title: str, found: Mapping[str, float], goals: Mapping[str, float]) -> str:
    """Return a line for each wait; waits and goals are in seconds, by the same names."""
    lines = [
        f"  {name:<20} {1000 * seconds:6.0f} ms   goal {1000 * goals[name]:.0f} ms"
        f"   {'met' if seconds <= goals[name] else 'missed'}"
        for name, seconds in found.items()
    ]
    return "\n".join([title, *lines])
