"""A student's header whose only fault is to declare exercises otherwise than exercises.h.

What the files need of it besides stays: it is compiled again without these declarations, and only
the functions that they are about lose by it.
"""

from __future__ import annotations

import re

from grader.build import diagnostics

_ENDS = ";{}"  # of what stands before a declaration


def without_changed(content: bytes, errors: str) -> bytes | None:
    """Return a header without the declarations in error; None when that is not all that is wrong.

    `errors` is what the compiler says of it alone. The lines keep their numbers.
    """
    found = diagnostics.errors(errors)
    if not found or not all(map(diagnostics.is_changed, found)):
        return None
    text = content.decode("utf-8", errors="surrogateescape")
    for each in found:
        # By its name, where it stands in its line: what came before is counted in its own place.
        if (shorter := _without(text, each.line, each.word)) is None:
            return None
        text = shorter
    return text.encode("utf-8", errors="surrogateescape")


def _without(text: str, line: int, name: str) -> str | None:
    """Return a text without the declaration of a name in a line; blanks stand in its place."""
    lines = text.splitlines(keepends=True)
    if not name or not 0 < line <= len(lines):
        return None
    start = len("".join(lines[: line - 1]))
    # Bounded, since a text may hold thousands that are never closed.
    declared = re.compile(rf"\b{name}\s*\([^;{{}}#]{{0,2000}};")
    found = declared.search(text, start)
    if found is None or ")" not in found[0] or found.start() > start + len(lines[line - 1]):
        return None
    begin = max(text.rfind(each, start, found.start()) for each in _ENDS) + 1 or start
    gone = re.sub(r"[^\n\r]", " ", text[begin : found.end()])
    return text[:begin] + gone + text[found.end() :]
