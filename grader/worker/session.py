"""The child's side of a session: a loaded library, its functions and its variables."""

from __future__ import annotations

import contextlib
import mmap
import struct
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from grader.worker.frames import COUNTER, TODO_BYTES, TRACE_OFFSET
from grader.worker.shared import Shared

GUARDED_BYTES = 4096  # tables of at least this size end at a guard page
CANARY = 0xA5
# Of the C library, to be declared beside the submission's functions.
LIBC = """
void *malloc(size_t size);
void free(void *memory);
int mprotect(void *start, size_t length, int protection);
"""


class Refused(Exception):
    """A request that cannot be served; the text goes to the parent."""


class StrayWrite(Exception):
    """The code wrote before the beginning of a table."""

    kind = "stray"


class UnsetResult(Exception):
    """The code returned a bool to which nothing had given a value."""

    kind = "unset"


class Table:
    """Memory handed to the code: ends at a page that cannot be written, and starts after another.

    With a sanitizer, plain malloc is better: every byte around it is watched.
    """

    def __init__(
        self, ffi: Any, libc: Any, content: bytes | memoryview, ctype: Any, guarded: bool
    ) -> None:
        self._ffi, self._libc, self._size = ffi, libc, len(content)
        self._map: mmap.mmap | None = None
        if guarded and len(content) >= GUARDED_BYTES:
            page = mmap.PAGESIZE
            whole = (len(content) + page - 1) // page * page
            self._map = mmap.mmap(-1, whole + 2 * page)
            start = int(ffi.cast("uintptr_t", ffi.from_buffer(self._map)))
            self._slack = whole - len(content)
            self._map[page : page + self._slack] = bytes([CANARY]) * self._slack
            libc.mprotect(ffi.cast("void *", start), page, 0)
            libc.mprotect(ffi.cast("void *", start + page + whole), page, 0)
            self.address = start + page + self._slack
        else:
            self.address = int(ffi.cast("uintptr_t", libc.malloc(max(len(content), 1))))
            if self.address == 0:
                raise MemoryError
        self.passed = self.pointer(ctype)
        ffi.memmove(self.passed, content, len(content))

    def pointer(self, ctype: Any = "char *") -> Any:
        """Return the address as a pointer of that type."""
        return self._ffi.cast(ctype, self.address)

    def copy_to(self, out: memoryview) -> None:
        """Copy the bytes. Raises StrayWrite when those just before have changed."""
        if self._map is not None:
            before = self._map[mmap.PAGESIZE : mmap.PAGESIZE + self._slack]
            if before.count(CANARY) != self._slack:
                raise StrayWrite
        self._ffi.memmove(out, self.pointer(), self._size)

    def free(self) -> None:
        """Give malloc's memory back; a mapping goes with the object."""
        if self._map is None:
            self._libc.free(self.pointer("void *"))


class WorkerSession:
    """The child's side of a session: one loaded library."""

    def __init__(self, ffi: Any, path: str, shared: Shared, sanitized: bool) -> None:
        self._ffi, self._shared, self._guarded = ffi, shared, not sanitized
        self._libc = ffi.dlopen(None)
        self._lib = ffi.dlopen(path, ffi.RTLD_LAZY)
        self._buffers: list[Table] = []
        self._todo = ffi.from_buffer("unsigned char[]", shared.page)
        # A library that is no submission has no exercises.
        with contextlib.suppress(ffi.error, AttributeError):
            self._lib.todo_page = self._todo
        self._lib.mrt_watch(self._todo + TRACE_OFFSET, sanitized)

    def call(self, head: dict[str, Any], payload: bytes | memoryview) -> memoryview:
        """Call a function `count` times; return the results, then each "table" as it is afterwards.

        `parameters` has a pair (kind, number of bytes) for each, and the payload their bytes, one
        after another: "value": `count` values; "table": `count` pieces of equal size, each laid in
        memory of its own whose address is passed; "address": `count` addresses, NULL being 0.
        """
        function = self._function(head)
        ctype, count = self._ffi.typeof(function), head["count"]
        columns = self._columns(head["parameters"], ctype.args, payload, count)
        void = ctype.result.kind == "void"
        results = self._ffi.new(f"{'char' if void else ctype.result.cname}[]", 0 if void else count)
        start = self._ffi.sizeof(results)
        sizes = [size if kind == "table" else 0 for kind, size in head["parameters"]]
        out = self._shared.answer(start + sum(sizes))
        tables = list(_cut(out[start:], sizes))
        for k in range(count):
            COUNTER.pack_into(self._shared.page, TODO_BYTES, k)
            arguments = [column(k) for column in columns]
            try:
                value = function(*[getattr(each, "passed", each) for each in arguments])
            except ValueError as error:  # a _Bool that is neither 0 nor 1
                raise UnsetResult from error
            if not void:
                results[k] = value
            for each, table in zip(arguments, tables, strict=True):
                if isinstance(each, Table):
                    each.copy_to(_piece(table, k, count))
                    each.free()
        self._ffi.memmove(out, results, start)
        return out

    def keep(self) -> bool:
        """Note all variables, for `renew`; return whether they can be put back."""
        return bool(self._lib.mrt_keep())

    def renew(self, head: dict[str, Any], payload: bytes | memoryview) -> bytes:
        """Put all variables back as they were noted, and free the buffers."""
        for each in self._buffers:
            each.free()
        self._buffers.clear()
        self._lib.mrt_renew()
        return b""

    def _function(self, head: dict[str, Any]) -> Any:
        """Return the function to call, in its wrapper."""
        try:
            with contextlib.suppress(AttributeError):  # it is not known but by its wrapper
                getattr(self._lib, head["name"])
            return getattr(self._lib, head["function"])
        except self._ffi.error as error:
            raise Refused(f"missing: {head['name']}") from error

    def _columns(
        self, parameters: list[tuple[str, int]], types: Any, payload: bytes | memoryview, count: int
    ) -> list[Callable[[int], Any]]:
        """Return, for each parameter, the function that gives the argument of call number k."""
        if len(parameters) != len(types):
            raise Refused(f"{len(parameters)} arguments for {len(types)} parameters")
        contents = _cut(memoryview(payload), [size for _, size in parameters])
        return [
            self._column(kind, ctype, content, count)
            for (kind, _), ctype, content in zip(parameters, types, contents, strict=True)
        ]

    def _column(
        self, kind: str, ctype: Any, content: memoryview, count: int
    ) -> Callable[[int], Any]:
        if kind == "table":
            return lambda k: self._table(_piece(content, k, count), ctype)
        # A pointer travels as its bytes too, so "address" and "value" are read alike.
        values = self._ffi.new(f"{ctype.cname}[]", count)
        if self._ffi.sizeof(values) != len(content):
            raise Refused(f"{len(content)} bytes for {count} values of {ctype.cname}")
        self._ffi.memmove(values, content, len(content))
        return lambda k: values[k]

    def _table(self, content: bytes | memoryview, ctype: Any) -> Table:
        return Table(self._ffi, self._libc, content, ctype, self._guarded)

    def get(self, head: dict[str, Any], payload: bytes | memoryview) -> memoryview:
        """Return the first `size` bytes of a global variable; the parent knows its size."""
        return self._copied(self._variable(head), head["size"])

    def set(self, head: dict[str, Any], payload: bytes | memoryview) -> bytes:
        """Write the first bytes of a global variable."""
        self._ffi.memmove(self._variable(head), payload, len(payload))
        return b""

    def _variable(self, head: dict[str, Any]) -> Any:
        try:
            pointer = self._ffi.addressof(self._lib, head["name"])
        except self._ffi.error as error:
            raise Refused(f"missing: {head['name']}") from error
        return self._ffi.cast("char *", pointer)

    def buffer(self, head: dict[str, Any], payload: bytes | memoryview) -> memoryview:
        """Keep a copy of the payload until the session ends; return its address."""
        self._buffers.append(self._table(payload, self._ffi.typeof("char *")))
        address = self._shared.answer(8)
        struct.pack_into("=Q", address, 0, self._buffers[-1].address)
        return address

    def peek(self, head: dict[str, Any], payload: bytes | memoryview) -> memoryview:
        """Return bytes at an address, such as one that a function has returned."""
        return self._copied(self._ffi.cast("char *", head["address"]), head["size"])

    def _copied(self, pointer: Any, size: int) -> memoryview:
        out = self._shared.answer(size)
        self._ffi.memmove(out, pointer, size)
        return out


def _cut(data: memoryview, sizes: Sequence[int]) -> Iterator[memoryview]:
    """Yield consecutive parts of these sizes."""
    start = 0
    for size in sizes:
        yield data[start : start + size]
        start += size


def _piece(data: memoryview, k: int, count: int) -> memoryview:
    """Return the part number k of `count` equal ones."""
    size = len(data) // count
    return data[k * size : (k + 1) * size]
