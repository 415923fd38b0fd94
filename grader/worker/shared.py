"""The memory that a session's process shares with the parent: its page, then room for large data.

A request that says so has its bytes at the start of the room, and its answer's go behind them: a
picture that goes through a socket is copied many times, and memory for it is found anew each time.
"""

from __future__ import annotations

import mmap
from typing import Any

from grader.worker.frames import ROOM_OFFSET, SHARED_BYTES, answer_offset


class Shared:
    """The child's side of the memory."""

    def __init__(self, descriptor: int) -> None:
        self._map = mmap.mmap(descriptor, SHARED_BYTES)
        self.page = memoryview(self._map)[:ROOM_OFFSET]
        self._answer = 0  # where the next one goes, in the room; 0: elsewhere

    def request(self, head: dict[str, Any], payload: bytes) -> bytes | memoryview:
        """Return the bytes of a request, wherever they are."""
        size = head.get("room")
        self._answer = 0 if size is None else answer_offset(size)
        if size is None:
            return payload
        return memoryview(self._map)[ROOM_OFFSET : ROOM_OFFSET + size]

    def answer(self, size: int) -> memoryview:
        """Return memory for the answer to that request."""
        if self._answer == 0:
            return memoryview(bytearray(size))
        return memoryview(self._map)[self._answer : self._answer + size]

    def reply(self, kind: str, data: bytes | memoryview) -> tuple[dict[str, Any], bytes]:
        """Return the frame for an answer: without what lies in the room."""
        if isinstance(data, memoryview) and data.obj is self._map:
            return {"is": kind, "room": len(data)}, b""
        return {"is": kind}, bytes(data)
