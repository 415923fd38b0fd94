"""The members of a .tar or .tar.gz, walked through as a stream: a small archive can hold terabytes.

What comes out is bounded in all, and what describes a member (its name, its date, what some tools
add) for itself: the library reads that into memory whatever length it claims.
"""

from __future__ import annotations

import gzip
import io
import tarfile
from collections.abc import Callable, Iterator
from functools import partial
from typing import BinaryIO

MAX_UNPACKED_BYTES = 300_000_000  # walked through, since a stream cannot be skipped over
MAX_HEADER_BYTES = 100_000  # before a member
MAX_EMPTY = 9  # readings beyond the end

Read = Callable[[int], tuple[bytes, str]]


class TooLongError(Exception):
    """More bytes come out of an archive than are walked through; `problem` is as in archives.py."""

    def __init__(self, problem: str) -> None:
        super().__init__(problem)
        self.problem = problem


class _Bounded(io.RawIOBase):
    """A stream that gives up after a number of bytes, which may be moved."""

    def __init__(self, stream: BinaryIO | gzip.GzipFile) -> None:
        self._stream, self._read, self._empty = stream, 0, 0
        self.end = MAX_HEADER_BYTES

    def read(self, size: int = -1) -> bytes:
        """Return the next bytes, at most `size`."""
        content = self._stream.read(size)
        self._read += len(content)
        # Who skips over what a header claims would ask again for every block of it.
        self._empty = 0 if content else self._empty + 1
        if self._empty > MAX_EMPTY:
            raise EOFError("it ends in the middle of a file")
        if self._read > self.end:
            raise TooLongError("header" if self.end < MAX_UNPACKED_BYTES else "unpacked")
        return content


def members(file: BinaryIO) -> Iterator[tuple[tarfile.TarInfo, Read]]:
    """Yield each member, and what reads so many bytes of it at most: (content, problem).

    Raises TooLongError, and what tarfile and gzip do.
    """
    packed = file.read(2) == b"\x1f\x8b"
    file.seek(0)
    stream = _Bounded(gzip.GzipFile(fileobj=file) if packed else file)
    # As a stream: headers too are read within the bound.
    with tarfile.open(fileobj=stream, mode="r|") as archive:
        while (member := archive.next()) is not None:
            # The library holds what it has seen for whoever looks back.
            archive.members = []  # type: ignore[attr-defined]
            # It reads ahead by less than a header.
            stream.end = min(archive.offset + MAX_HEADER_BYTES, MAX_UNPACKED_BYTES)
            yield member, partial(_content, archive, member)


def _content(archive: tarfile.TarFile, member: tarfile.TarInfo, most: int) -> tuple[bytes, str]:
    if member.sparse is not None:
        return b"", "special"
    file = archive.extractfile(member)
    return (file.read(most), "") if file else (b"", "damaged")
