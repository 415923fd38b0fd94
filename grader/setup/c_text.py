"""What of a C source is code: comments, strings and characters are told apart in one pass.

What is begun always ends, at the end of the line or of the file.
"""

from __future__ import annotations

import re

SILENT = re.compile(
    r"""(?P<literal>"(?:\\.|[^"\\\n])*"?|'(?:\\.|[^'\\\n])*'?)"""
    r"""|(?P<comment>//[^\n]*|/\*.*?(?:\*/|\Z))""",
    re.DOTALL,
)
_VISIBLE = re.compile(r"[^\n]")


def without_comments(text: str) -> str:
    """Return a source without its comments; strings and characters stay."""
    return SILENT.sub(lambda found: found["literal"] or "", text)


def blanked(text: str, literals: bool = True) -> str:
    """Return a source with blanks for its comments, and for its strings and characters.

    Lines and columns stay as they are.
    """

    def blank(found: re.Match[str]) -> str:
        keep = found["literal"] and not literals
        return found[0] if keep else _VISIBLE.sub(" ", found[0])

    return SILENT.sub(blank, text)
