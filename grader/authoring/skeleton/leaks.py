"""Looks for the solution in what is handed out, wherever in a file or in an archive it may hide.

A line of the solution counts when it stands between the marks of reference/ and nowhere in what
students get anyway, and is long enough to be nobody else's: `node->child[k] = NULL;` is not.
Whitespace, quotes escaped in a notebook and comments around a line do not hide it.
"""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from grader.authoring.skeleton.skeleton import SUSPECT, find_regions, read_text
from grader.course import exercises

MIN_LINE = 14  # characters, without whitespace, of a line that is looked for as a whole line
MIN_PART = 24  # of one that is looked for within others: comments, strings, joined lines
_COMMENT = re.compile(r"//.*|/\*.*?\*/")
# Whoever visits an array or an image writes this line.
_LOOP = re.compile(r"for\(int(\w)=0;\1<[\w*]+;\1\+\+\)\{?")
_PRINTABLE = re.compile(rb"[\t\n\r\x20-\x7e]{12,}")


@dataclass(frozen=True)
class Leak:
    """Where a part of the solution was found, in which line (0: the whole file), and which part."""

    path: str
    line: int
    what: str

    @property
    def place(self) -> str:
        """The file and the line, as compilers write them."""
        return f"{self.path}:{self.line}" if self.line else self.path


def squeezed(line: str) -> str:
    """Return a line of C without whitespace and comments."""
    return _bare(_COMMENT.sub("", line))


def solution_lines(reference: Path, public: Path) -> dict[str, str]:
    """Return the solution's own lines, squeezed, with where they stand ("main.c:12").

    `public` is the folder of what students get: a line that stands there too is not the solution's.
    Raises SkeletonError.
    """
    rules = exercises.load()
    known = {each.id for each in rules.exercises}
    given = {squeezed(line) for path in public.glob("*.[ch]") for line in _lines(path)}
    found: dict[str, str] = {}
    for name in rules.student:
        lines = _lines(reference / name)
        for region in find_regions(reference / name, lines, known):
            for index in range(region.begin + 1, region.end):
                key = squeezed(lines[index])
                if len(key) >= MIN_LINE and key not in given and not _LOOP.fullmatch(key):
                    found.setdefault(key, f"{name}:{index + 1}")
    return found


def find(files: Mapping[str, bytes], reference: Path, public: Path) -> Iterator[Leak]:
    """Yield what of the solution is in the files, by path. Raises SkeletonError."""
    lines = solution_lines(reference, public)
    secret = _sources(reference, public)
    for path, content in files.items():
        for name, part in _unpacked(path, content):
            if part in secret:
                yield Leak(name, 0, secret[part])
            yield from _in_text(name, _text(part), lines)


def _lines(path: Path) -> list[str]:
    return read_text(path).rstrip("\n").split("\n")


def _sources(reference: Path, public: Path) -> dict[bytes, str]:
    """Return the names of the files beside the expected data, by their content."""
    expected = reference / "expected"
    # A file without a mark is the same on both sides.
    given = {path.read_bytes() for path in public.glob("*.[ch]")}
    return {
        path.read_bytes(): str(path.relative_to(reference.parent))
        for path in sorted(reference.rglob("*"))
        if path.is_file() and expected not in path.parents and path.read_bytes() not in given
    }


def _unpacked(path: str, content: bytes) -> Iterator[tuple[str, bytes]]:
    """Yield a file, and what is inside when it is an archive (.npz is one)."""
    yield path, content
    if not content.startswith(b"PK\3\4"):
        return
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        for name in archive.namelist():
            yield from _unpacked(f"{path}/{name}", archive.read(name))


def _text(content: bytes) -> str:
    """Return a file as text: of a binary one, what can be read in it."""
    if b"\0" in content:
        content = b"\n".join(_PRINTABLE.findall(content))
    text = content.decode("utf-8", errors="replace")
    return text.replace('\\"', '"').replace("\\n", " ")


def _in_text(path: str, text: str, lines: Mapping[str, str]) -> Iterator[Leak]:
    if mark := SUSPECT.search(text):
        yield Leak(path, text.count("\n", 0, mark.start()) + 1, mark[0])
    # In a notebook a line stands between quotes.
    rows = [squeezed(line).strip("\"',") for line in text.split("\n")]
    for number, row in enumerate(rows, 1):
        if row in lines:
            yield Leak(path, number, lines[row])
    whole = _bare(text)
    for key, where in lines.items():
        if len(key) >= MIN_PART and key in whole and key not in rows:
            number = next((n for n, row in enumerate(text.split("\n"), 1) if key in _bare(row)), 0)
            yield Leak(path, number, where)


def _bare(text: str) -> str:
    return re.sub(r"\s+", "", text)
