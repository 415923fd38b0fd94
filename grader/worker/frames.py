"""Frames: what travels between the parent, the worker and its children.

A frame is a head of 12 bytes (length of the JSON, length of the raw bytes), a JSON object, and raw
bytes. Requests of the parent to the worker, each answered by one reply:
    lock     {machine, paths} + code        shuts the worker in: root becomes nobody; unless machine
                                            is "", its sessions may make the system calls of that
                                            list only, and read these paths
    library  {key, path, sanitized} + code  declares a library; the code makes cffi's `ffi`
    fork     {key, cpu, space}              starts a session -> pid; four descriptors come with it:
                                            the session's socket, files for stdout and stderr, the
                                            page; space: bytes of addresses, 0 for no limit
    reap     {pid, grace, ask}              ends a session -> wait status, CPU seconds; ask: first
                                            have it note where it is
    release  {pid, grace}                   lets a session end by itself, and buries it later
The worker's first frame, "ready", answers no request; a session's first, "locked", says that the
submission's code comes now.
Requests of the parent to a session:
    call     {function, count, parameters} + arguments   -> results, tables afterwards
    get      {name, size}                   -> bytes of a global variable
    set      {name} + bytes                 writes a global variable
    buffer   {} + bytes                     -> address of memory that stays as long as the session
    peek     {address, size}                -> bytes of the session's memory
    close    {}                             ends the session, without a reply
A reply is {"is": KIND} and bytes: done; refused (the request makes no sense, or asks for what the
library lacks: "missing: NAME"); stray (the code wrote just before a table); memory (none is left);
unloadable.

The page is memory shared with the session's process, which a crash leaves as it is: MRT_TODO's
markers, the number of the call that runs, and where the code was when a signal came (watch.c).
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
TRACE_OFFSET = 136  # a multiple of 8
FRAMES = 32
TRACE = struct.Struct(f"=QQII{FRAMES}Q")  # library's address, instruction, signal, count, callers
PAGE_BYTES = TRACE_OFFSET + TRACE.size
MAX_JSON_BYTES = 1 << 16
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
