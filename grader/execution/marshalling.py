"""The arguments of calls as the worker takes them, and its answers as numpy arrays."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from grader.build.records import Function
from grader.execution.dtypes import Types, pack, unpack

Array = npt.NDArray[Any]


class Address(int):
    """An address in the session's process."""


@dataclass(frozen=True)
class Reply:
    """What a call gave: `result` (None for void), and what pointers point to afterwards."""

    result: Any
    args: dict[str, Array]


@dataclass(frozen=True)
class Packed:
    """An argument as the worker takes it; a table comes back with that dtype and shape."""

    name: str
    kind: str
    payload: bytes
    dtype: np.dtype[Any] | None = None
    lead: tuple[int, ...] = ()

    @property
    def size(self) -> int:
        """The number of its bytes, there and back."""
        return len(self.payload)


def packed(
    types: Types, function: Function, count: int, args: Sequence[Any], many: bool
) -> Iterator[Packed]:
    """Yield the arguments of `count` calls; of `many`, the first axis counts the calls."""
    if function.boxed:
        dtype = types.dtype(function.result)
        yield _table("", np.zeros(count, dtype), dtype, count, many=True)
    for parameter, value in zip(function.parameters, args, strict=True):
        by_address = parameter.name in function.by_address
        if not parameter.pointee and not by_address:
            payload = pack(value, types.dtype(parameter.ctype), (count,))
            yield Packed(parameter.name, "value", payload)
        elif value is None or isinstance(value, Address):
            payload = int(value or 0).to_bytes(8, sys.byteorder) * count
            yield Packed(parameter.name, "address", payload)
        else:
            dtype = types.dtype(parameter.pointee or parameter.ctype)
            yield _table(parameter.name, value, dtype, count, many)


def _table(name: str, value: Any, dtype: np.dtype[Any], count: int, many: bool) -> Packed:
    shape = np.shape(value)
    lead = shape[: len(shape) - len(dtype.shape)]
    if not many or not lead or lead[0] != count:
        lead = (count, *lead)
    return Packed(name, "table", pack(value, dtype, lead), dtype, lead)


def unpacked(
    data: memoryview, result: np.dtype[Any] | None, count: int, arguments: Sequence[Packed]
) -> Reply:
    """Return an answer's arrays: the results, unless None are due, then the tables."""
    offset = 0
    values = None
    if result is not None:
        offset = result.itemsize * count
        values = unpack(data[:offset], result, (count,))
    tables: dict[str, Array] = {}
    for each in arguments:
        if each.dtype is not None:
            tables[each.name] = unpack(data[offset : offset + each.size], each.dtype, each.lead)
            offset += each.size
    if "" in tables:
        values = tables.pop("")
    return Reply(values, tables)
