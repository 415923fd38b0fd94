"""Sources that a compiler never comes to the end of, and what the given ones have."""

from __future__ import annotations

import re

from grader.course.exercises import CORE


def _endless() -> str:
    """Return macros that expand to nothing, ten times as often at each level: time, no memory."""
    levels = [f"#define E{k} " + " ".join([f"E{k - 1}"] * 10) for k in range(1, 13)]
    return "\n".join(["#define E0", *levels, "E12", "int x;", ""])


ENDLESS = _endless()


def scenes() -> range:
    """Return the numbers of the scenes that core_c/scene.c has."""
    source = (CORE / "scene.c").read_text(encoding="utf-8")
    return range(len(re.findall(r"^static void scene_\d+\(void\)", source, re.MULTILINE)))
