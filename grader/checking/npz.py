"""Files of arrays: numpy's `.npz`, without pickle, read one array at a time.

np.load takes five times as long over many small arrays, and twice as long over large ones.
"""

from __future__ import annotations

import io
import math
import struct
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]

_LOCAL_BYTES = 30  # of a member's own header in the archive, before its name
_LENGTHS = struct.Struct("<HH")  # of the name and of what follows it, at their end
_MAGIC_BYTES = 10  # of an array's file, with the length of the header that follows


def archived(arrays: Mapping[str, Array]) -> bytes:
    """Return the content of a file of arrays: the same bytes for the same arrays."""
    memory = io.BytesIO()
    with zipfile.ZipFile(memory, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, value in arrays.items():
            part = io.BytesIO()
            np.save(part, np.asarray(value, order="C"), allow_pickle=False)
            # ZipInfo's own date, not today's: the bytes depend on the data alone.
            archive.writestr(zipfile.ZipInfo(f"{name}.npy"), part.getvalue(), zipfile.ZIP_DEFLATED)
    return memory.getvalue()


class Arrays(Mapping[str, Array]):
    """The arrays of a file, by name; each is decoded when it is asked for, and may be written to.

    `content` is what `archived` gave, and was verified: there is no other checksum. Raises
    ValueError, at once or later, when it is something else.
    """

    def __init__(self, content: bytes) -> None:
        self._content = content
        try:
            with zipfile.ZipFile(io.BytesIO(content)) as archive:
                members = archive.infolist()
        except zipfile.BadZipFile as error:
            raise ValueError(str(error)) from error
        self._members = {each.filename.removesuffix(".npy"): each for each in members}

    def __getitem__(self, name: str) -> Array:
        try:
            return _array(_inflated(self._content, self._members[name]))
        except (struct.error, zlib.error) as error:
            raise ValueError(f"{name}: {error}") from error

    def __iter__(self) -> Iterator[str]:
        return iter(self._members)

    def __len__(self) -> int:
        return len(self._members)


def _inflated(content: bytes, member: zipfile.ZipInfo) -> bytes:
    """Return a member's bytes at once: zipfile puts them together from pieces of 4 kB."""
    lengths = _LENGTHS.unpack_from(content, member.header_offset + _LOCAL_BYTES - _LENGTHS.size)
    start = member.header_offset + _LOCAL_BYTES + sum(lengths)
    data = memoryview(content)[start : start + member.compress_size]
    return zlib.decompress(data, -zlib.MAX_WBITS, max(member.file_size, 1))


def _array(content: bytes) -> Array:
    start = _MAGIC_BYTES + int.from_bytes(content[_MAGIC_BYTES - 2 : _MAGIC_BYTES], "little")
    shape, dtype = _header(content[:start])
    return np.frombuffer(bytearray(content), dtype, math.prod(shape), start).reshape(shape)


@cache
def _header(content: bytes) -> tuple[tuple[int, ...], np.dtype[Any]]:
    """Return shape and dtype, which takes a parser; few headers differ."""
    file = io.BytesIO(content)
    # Not every numpy says of what type they are.
    version = np.lib.format.read_magic(file)  # type: ignore[no-untyped-call, unused-ignore]
    if version != (1, 0):
        raise ValueError("not an array of ours")
    read = np.lib.format.read_array_header_1_0
    shape, is_fortran, dtype = read(file)  # type: ignore[no-untyped-call, unused-ignore]
    if is_fortran or dtype.hasobject:
        raise ValueError("not a plain array")
    return shape, dtype
