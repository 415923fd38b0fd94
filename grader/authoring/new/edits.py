"""What is new in files: blocks put behind what stands there. All files are written, or none."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from grader.course.exercises import ROOT
from grader.course.message import GraderError
from grader.files import write_whole

MARK = "TO WRITE:"
_ENTRY = re.compile(r'"(tp\d\.[\w.]+)" = ')
_NOTE = re.compile(rf""".*?{MARK} (.*?)(?: \*/| -->|\'\'\'|\\n")?$""")


class NewError(GraderError):
    """What is asked for is there already, or has no place: one line with the cure."""

    code = 2


@dataclass(frozen=True)
class Edit:
    """A file with something new in it: its path from the root, and its whole text."""

    path: str
    text: str

    def notes(self) -> list[str]:
        """Return what there is to write, as the stubs say it."""
        return [found[1] for line in self.text.splitlines() if (found := _NOTE.match(line))]


def write(edits: Sequence[Edit], root: Path = ROOT) -> None:
    """Write files whole. Raises OSError."""
    for each in edits:
        write_whole(root / each.path, each.text)


def created(path: str, text: str, root: Path = ROOT) -> Edit:
    """Return a new file. Raises NewError when it is there already."""
    if (root / path).exists():
        raise NewError(f"{path}: it is there already, and stays as it is")
    return Edit(path, text)


def read(path: str, root: Path = ROOT) -> str:
    """Return the text of a file. Raises NewError."""
    try:
        return (root / path).read_text(encoding="utf-8")
    except OSError as error:
        raise NewError(f"{path}: {error.strerror}; put the original file back") from error


def behind(path: str, text: str, last: str, block: str) -> str:
    """Return the text with a block behind the last place that a pattern matches. Raises NewError.

    The pattern sees lines (re.MULTILINE); what it matches stays in front of the block.
    """
    found = [*re.finditer(last, text, re.MULTILINE)]
    if not found:
        raise NewError(f"{path}: there is no place for it; nothing matches {last}")
    end = found[-1].end()
    return text[:end] + block + text[end:]


def in_table(path: str, text: str, table: str, check: str, entry: str) -> str:
    """Return a file of messages with an entry in a table, behind those of the nearest checks."""
    lines = text.splitlines(keepends=True)
    start = next((k for k, line in enumerate(lines) if line.strip() == f"[{table}]"), None)
    if start is None:
        raise NewError(f"{path}: there is no [{table}]")
    places: list[tuple[int, int]] = []  # how near the check of an entry is, and where it ends
    near = 0
    for k in range(start + 1, len(lines)):
        if lines[k].startswith("["):
            break
        if found := _ENTRY.match(lines[k]):
            near = _shared(found[1], check)
        if lines[k].strip():
            places.append((near, k + 1))
    _, end = max(places, default=(0, start + 1))
    return "".join([*lines[:end], entry, *lines[end:]])


def _shared(one: str, other: str) -> int:
    """Return how many parts two ids begin with alike."""
    pairs = zip(one.split("."), other.split("."), strict=False)
    return next((k for k, (a, b) in enumerate(pairs) if a != b), 3)
