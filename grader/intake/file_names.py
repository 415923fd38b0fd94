"""What browsers and systems make of a file's name: a second copy, a hidden extension.

main (1).c, main-1.c, main 2.c, main - Copie.c, Copie de main.c, main (copy).c   were main.c
main.c.txt                                                                       too
"""

from __future__ import annotations

import re

MAX_NAME = 255  # characters: no system has longer names
_COPY_OF = re.compile(r"(?:copie|copy)(?: ?\(\d+\))? (?:de|of) (?P<name>.+)", re.IGNORECASE)
_COPY = re.compile(
    r"(?P<stem>.+?)(?: ?\(\d+\)| ?\((?:\w+ )?cop(?:y|ie)(?: \d+)?\)| - cop(?:y|ie)(?: ?\(\d+\))?"
    r"| cop(?:y|ie)(?: \d+)?| \d+|-\d+)(?P<suffix>\.[^. ]+)",
    re.IGNORECASE,
)
_HIDDEN = re.compile(r"(?P<name>.+\.(?:[chCH]|txt|TXT))\.txt", re.IGNORECASE)


def original(name: str) -> str:
    """Return the name that a file had before browsers and systems changed it."""
    before = name if len(name) > MAX_NAME else ""
    while name != before:
        before = name
        name = name.strip()
        if found := _HIDDEN.fullmatch(name) or _COPY_OF.fullmatch(name):
            name = found["name"]
        elif found := _COPY.fullmatch(name):
            name = found["stem"] + found["suffix"]
    return name
