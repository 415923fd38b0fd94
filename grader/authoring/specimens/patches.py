"""The reference changed by a patch: a known mistake, or a right solution written differently.

A patch is a unified diff of files of reference/, from the repository's root. What it changes is
found by its text, not by its line numbers: the rest of the file may grow and shrink around it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from grader.course import exercises
from grader.course.message import GraderError
from grader.intake.originals import REFERENCE
from grader.intake.records import Submission

_FILE = re.compile(r"\+\+\+ (?:b/)?reference/(\S+)")
_HUNK = re.compile(r"@@ -(\d+)")


class PatchError(GraderError):
    """A patch cannot be read, or does not fit the reference: the file and the cure in one line."""


@dataclass
class _Hunk:
    """A change of a file: its old lines around line `start` (from 0), and the new ones."""

    file: str
    start: int
    old: list[str] = field(default_factory=list)
    new: list[str] = field(default_factory=list)

    def add(self, line: str) -> None:
        """Take a line of the diff, with its sign."""
        if line[:1] != "+":
            self.old.append(line[1:])
        if line[:1] != "-":
            self.new.append(line[1:])

    def shorter(self) -> _Hunk:
        """Return the change with a line less of what stands around it, at either end."""
        first = int(self.old[:1] == self.new[:1])
        last = int(self.old[-1:] == self.new[-1:])
        old, new = (each[first : len(each) - last] for each in (self.old, self.new))
        return _Hunk(self.file, self.start + first, old, new) if old else self


def reference() -> dict[str, str]:
    """Return the reference's files, those that students write, by name."""
    names = exercises.load().student
    return {name: (REFERENCE / name).read_text(encoding="utf-8") for name in names}


def patched(patch: Path, files: Mapping[str, str]) -> dict[str, str]:
    """Return the files with the changes of a patch. Raises PatchError."""
    try:
        hunks = _hunks(patch.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, ValueError) as error:
        raise PatchError(f"{patch.name}: not a unified diff of reference/: {error}") from error
    if not hunks:
        raise PatchError(f"{patch.name}: changes no file of reference/")
    changed = dict(files)
    for hunk in hunks:
        if hunk.file not in changed:
            raise PatchError(f"{patch.name}: {hunk.file} is no file of students in reference/")
        lines = changed[hunk.file].split("\n")
        # As patch does it: what stands around the change may have changed.
        for each in (hunk, hunk.shorter(), hunk.shorter().shorter()):
            place = _place(each, lines)
            if place is not None:
                break
        else:
            raise PatchError(
                f"{patch.name}: line {hunk.start + 1} of {hunk.file} has changed; make it again"
            )
        lines[place : place + len(each.old)] = each.new
        changed[hunk.file] = "\n".join(lines)
    return changed


def submission(name: str, files: Mapping[str, str]) -> Submission:
    """Return files as a submission."""
    content = {file: text.encode() for file, text in files.items()}
    missing = tuple(each for each in exercises.load().student if each not in content)
    return Submission(name, content, missing)


def _hunks(text: str) -> list[_Hunk]:
    hunks: list[_Hunk] = []
    file = ""
    for line in text.splitlines():
        if found := _FILE.match(line):
            file = found[1]
        elif file and (found := _HUNK.match(line)):
            hunks.append(_Hunk(file, int(found[1]) - 1))
        elif not line.startswith(("--- ", "diff ", "index ")):
            if not hunks or line[:1] not in ("", " ", "+", "-"):
                raise ValueError(f"unknown line {line!r}")
            hunks[-1].add(line)
    return hunks


def _place(hunk: _Hunk, lines: list[str]) -> int | None:
    """Return where the old lines stand, nearest to where the patch says; None when nowhere."""
    size = len(hunk.old)
    places = [k for k in range(len(lines) - size + 1) if lines[k : k + size] == hunk.old]
    return min(places, key=lambda k: abs(k - hunk.start), default=None)
