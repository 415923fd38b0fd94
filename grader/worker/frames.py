"""Frames: what travels between the parent, the worker and its children.

A frame is a head of 12 bytes (length of the JSON, length of the raw bytes), a JSON object, and raw
bytes. Requests of the parent to the worker, in order; only the last has a reply:
    lock     {machine, paths} + code        shuts the worker in: root becomes nobody; unless machine
                                            is "", its sessions may make the system calls of that
                                            list only, and read these paths
    library  {key, path, sanitized} + code  declares a library; the code makes cffi's `ffi`
    fork     {session, key, cpu, each, space}
                                            starts a session, by a number of the parent's; four
                                            descriptors come with it: the session's socket, files
                                            for stdout and stderr, the page; cpu seconds of the
                                            whole, or of each "call", or from one "renew" to the
                                            next; space: bytes of addresses, 0 for no limit
    release  {session, grace}               lets a session end by itself, and buries it later
    reap     {session, grace, ask}          ends a session -> wait status (0: it had to be killed),
                                            CPU seconds; ask: first have it note where it is
The worker's first frame, "ready", answers no request; a session's first, "locked", says that the
submission's code comes now, and the second, "done", that its library is loaded; of a session that
can be renewed, it has one byte, 0 when the library cannot.
Requests of the parent to a session:
    call     {name, function, count, parameters} + arguments   -> results, tables afterwards;
                                            function: its wrapper in the library
    get      {name, size}                   -> bytes of a global variable
    set      {name} + bytes                 writes a global variable; without a reply when it can
    buffer   {} + bytes                     -> address of memory that stays as long as the session
    peek     {address, size}                -> bytes of the session's memory
    renew    {}                             puts all variables back as they were first; without a
                                            reply when it can
    close    {}                             ends the session, without a reply
A reply is {"is": KIND} and bytes: done; refused (the request makes no sense, or asks for what the
library lacks: "missing: NAME"); stray (the code wrote just before a table); unset (it returned a
bool that is neither true nor false); memory (none is left); unloadable.

The page is memory shared with the session's process, which a crash leaves as it is: MRT_TODO's
markers, the number of the call that runs, where the code was when a signal came (watch.c), and what
it has tried that isolation may refuse (acts.c).
Behind it is room: a request with "room" has that many of its bytes there instead, and so has its
answer, behind them (shared.py).
"""

from __future__ import annotations

import json
import socket
import struct
import time
from typing import Any

HEAD = struct.Struct("<IQ")
EXITED = struct.Struct("<id")  # wait status, CPU seconds
COUNTER = struct.Struct("<I")
TODO_BYTES = 128
TRACE_OFFSET = 136  # a multiple of 8
FRAMES = 32
# The library's address, the instruction, the top of the stack, the address that could not be used,
# signal, count, callers: see watch.c.
TRACE = struct.Struct(f"=QQQQII{FRAMES}Q")
# The first act that was refused, and the first that worked: from where, and its kind.
ACTS = struct.Struct("=QIIQII")
ACTS_OFFSET = TRACE_OFFSET + TRACE.size
KINDS = ("", "thread", "process", "file", "network")
PAGE_BYTES = ACTS_OFFSET + ACTS.size
ROOM_OFFSET, ROOM_BYTES = 4096, 32 << 20  # for two pictures of 1280x720
SHARED_BYTES = ROOM_OFFSET + ROOM_BYTES
LARGE_BYTES = 1 << 15  # from here on, it is worth it
MAX_JSON_BYTES = 1 << 16
DESCRIPTORS = 4  # that come with a fork request
MAX_READ_BYTES = 1 << 18  # at once


def answer_offset(size: int) -> int:
    """Return where the answer lies in the shared memory, to a request of so many bytes there."""
    return ROOM_OFFSET + (size + 63) // 64 * 64


class Reader:
    """Reads frames from a socket, of which some first bytes may be known already.

    `ahead` is how many bytes may be read at once, beyond the frame if more are there.
    """

    def __init__(self, sock: socket.socket, start: bytes = b"", ahead: int = 1 << 16) -> None:
        self._sock, self._held, self._ahead = sock, bytearray(start), ahead

    def frame(
        self, limit: int = 1 << 33, deadline: float | None = None
    ) -> tuple[dict[str, Any], bytes]:
        """Read one frame. `deadline` is a time of time.monotonic().

        Raises EOFError at the end, ValueError when the frame is malformed or its payload longer
        than `limit`, TimeoutError at the deadline: the frame may then be waited for again.
        """
        self._fill(HEAD.size, deadline)
        head_length, length = HEAD.unpack_from(self._held)
        if head_length > MAX_JSON_BYTES or length > limit:
            raise ValueError("frame too long")
        start = HEAD.size + head_length
        self._fill(start + length, deadline)
        head = json.loads(bytes(self._held[HEAD.size : start]))
        if not isinstance(head, dict):
            raise ValueError("malformed frame")
        payload = bytes(self._held[start : start + length])
        del self._held[: start + length]
        return head, payload

    def _fill(self, length: int, deadline: float | None) -> None:
        """Read until so many bytes are held."""
        while (missing := length - len(self._held)) > 0:
            if deadline is not None:
                self._sock.settimeout(max(deadline - time.monotonic(), 1e-3))
            data = self._sock.recv(min(max(missing, self._ahead), MAX_READ_BYTES))
            if not data:
                raise EOFError
            self._held += data


def frame(head: dict[str, Any], payload: bytes = b"") -> bytes:
    """Return the bytes of one frame."""
    text = json.dumps(head).encode()
    return b"".join((HEAD.pack(len(text), len(payload)), text, payload))
