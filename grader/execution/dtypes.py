"""numpy dtypes of the C types, from the same declarations that the worker reads.

A struct becomes a structured dtype with C's offsets; members of an anonymous union overlap, as in
C. vec3, color and point3 become three float32: an array of n points has shape (n, 3), and so has
the field "orig" of n rays. A pointer becomes a uint64, an address in the worker.
"""

from __future__ import annotations

import math
import re
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from grader.build.records import Binding
from grader.sandbox.ffi_source import library_source

_NOT_INTEGERS = {"char": "S1", "_Bool": "?", "float": "f4", "double": "f8"}
_VECTOR = ("x", "y", "z")
# A length such as [96 * 64], which cffi's compiled part does not read by itself.
_PRODUCT = re.compile(r"\d+(?: \* \d+)+")


class Types:
    """The types of one binding; what its library's path serves for is said in abi.py."""

    def __init__(self, binding: Binding, library: str = "") -> None:
        self.binding = binding
        self._ffi = _declared(library_source(binding.cdef, library))
        self._known: dict[str, np.dtype[Any]] = {}

    def dtype(self, ctype: str) -> np.dtype[Any]:
        """Return the dtype of a C type such as "ray" or "color [3]". Raises KeyError."""
        if ctype not in self._known:
            try:
                self._known[ctype] = self._make(self._ffi.typeof(_PRODUCT.sub(_multiplied, ctype)))
            except self._ffi.error as error:
                raise KeyError(f"no C type {ctype!r}: {error}") from error
        return self._known[ctype]

    @cached_property
    def layout(self) -> tuple[int, ...]:
        """Sizes and offsets of every struct, in the order of the shim's table."""
        numbers: list[int] = []
        for struct, fields in self.binding.structs.items():
            numbers.append(self._ffi.sizeof(struct))
            numbers += [self._ffi.offsetof(struct, name) for name in fields]
        return tuple(numbers)

    def _make(self, ctype: Any) -> np.dtype[Any]:
        if ctype.kind == "primitive":
            return np.dtype(self._primitive(ctype))
        if ctype.kind in ("pointer", "function"):
            return np.dtype("u8")
        if ctype.kind == "array":
            item = self._make(ctype.item)
            return np.dtype((item.base, (ctype.length, *item.shape)))
        fields = dict(ctype.fields)
        if tuple(fields) == _VECTOR:
            return np.dtype((np.float32, (3,)))
        return np.dtype(
            {
                "names": list(fields),
                "formats": [self._make(each.type) for each in fields.values()],
                "offsets": [each.offset for each in fields.values()],
                "itemsize": self._ffi.sizeof(ctype),
            }
        )

    def _primitive(self, ctype: Any) -> str:
        if ctype.cname in _NOT_INTEGERS:
            return _NOT_INTEGERS[ctype.cname]
        signed = int(self._ffi.cast(ctype, -1)) < 0
        return f"{'i' if signed else 'u'}{self._ffi.sizeof(ctype)}"


@lru_cache(maxsize=8)
def _declared(source: bytes) -> Any:
    """Return the cffi object of declarations: kept, since cffi never frees the types it makes."""
    names: dict[str, Any] = {}
    exec(source, names)  # as the worker: no parser is needed
    return names["ffi"]


def _multiplied(product: re.Match[str]) -> str:
    return str(math.prod(map(int, product[0].split(" * "))))


def first(dtype: np.dtype[Any], count: int | None) -> np.dtype[Any]:
    """Return the dtype of an array's first `count` items; None: of the whole."""
    if count is None:
        return dtype
    if not dtype.shape or not 0 <= count <= dtype.shape[0]:
        raise ValueError(f"{count} items of {dtype}")
    return np.dtype((dtype.base, (count, *dtype.shape[1:])))


def pack(value: Any, dtype: np.dtype[Any], lead: tuple[int, ...]) -> bytes:
    """Return C's bytes of a value, which is repeated as often as `lead` asks for."""
    array = np.asarray(value, dtype.base)
    return np.broadcast_to(array, (*lead, *dtype.shape)).tobytes()


def unpack(
    data: bytes | bytearray | memoryview, dtype: np.dtype[Any], lead: tuple[int, ...]
) -> npt.NDArray[Any]:
    """Return an array of C's bytes, which can be written; it may be those bytes themselves."""
    array = np.frombuffer(data, dtype.base).reshape((*lead, *dtype.shape))
    return array if array.flags.writeable and array.flags.aligned else array.copy()
