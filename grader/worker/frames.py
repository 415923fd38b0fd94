"""Frames: what travels between the parent, the worker and its children.

A frame is a head of 12 bytes (length of the JSON, length of the raw bytes), a JSON object, and raw
bytes. Requests of the parent to the worker, each answered by one reply:
    library  {key, path, sanitized} + cdef  declares a library
    fork     {key, cpu, memory}             starts a session -> pid; four descriptors come with it:
                                            the session's socket, files for stdout and stderr, the
                                            page
    reap     {pid, grace}                   ends a session -> wait status, CPU seconds
Requests of the parent to a session:
    call     {function, count, parameters} + arguments   -> results, tables afterwards
    get      {name, size}                   -> bytes of a global variable
    set      {name} + bytes                 writes a global variable
    buffer   {} + bytes                     -> address of memory that stays as long as the session
    peek     {address, size}                -> bytes of the session's memory
    close    {}                             ends the session, without a reply
A reply is {"is": KIND} and bytes: done; refused (the request makes no sense, or asks for what the
library lacks: "missing: NAME"); stray (the code wrote just before a table); unloadable.

The page is memory shared with the session's process, which a crash leaves as it is: MRT_TODO's
markers, then the number of the call that runs.
"""

from __future__ import annotations

import json
import socket
import struct
import time
from collections.abc import Sequence
from typing import Any

HEAD = struct.Struct("<IQ")
EXITED = struct.Struct("<id")  # wait status, CPU seconds
COUNTER = struct.Struct("<I")
TODO_BYTES = 128
PAGE_BYTES = TODO_BYTES + COUNTER.size
MAX_JSON_BYTES = 1 << 22
DESCRIPTORS = 4  # that come with a fork request


def read_frame(
    sock: socket.socket, limit: int = 1 << 33, deadline: float | None = None, start: bytes = b""
) -> tuple[dict[str, Any], bytes]:
    """Read one frame, whose first bytes may be known already.

    `deadline` is a time of time.monotonic(). Raises EOFError at the end, TimeoutError at the
    deadline, ValueError when the frame is malformed or its payload longer than `limit`.
    """
    start += _read_exactly(sock, HEAD.size - len(start), deadline)
    head_length, length = HEAD.unpack(start)
    if head_length > MAX_JSON_BYTES or length > limit:
        raise ValueError("frame too long")
    head = json.loads(_read_exactly(sock, head_length, deadline))
    if not isinstance(head, dict):
        raise ValueError("malformed frame")
    return head, _read_exactly(sock, length, deadline)


def write_frame(
    sock: socket.socket,
    head: dict[str, Any],
    payload: bytes = b"",
    descriptors: Sequence[int] = (),
) -> None:
    """Write one frame; descriptors travel with its first bytes."""
    text = json.dumps(head).encode()
    start = HEAD.pack(len(text), len(payload))
    sent = socket.send_fds(sock, [start], descriptors) if descriptors else 0
    sock.sendall(start[sent:] + text)
    sock.sendall(payload)


def _read_exactly(sock: socket.socket, length: int, deadline: float | None) -> bytes:
    data = bytearray(length)
    view = memoryview(data)
    while view:
        if deadline is not None:
            sock.settimeout(max(deadline - time.monotonic(), 1e-3))
        count = sock.recv_into(view)
        if count == 0:
            raise EOFError
        view = view[count:]
    return bytes(data)
