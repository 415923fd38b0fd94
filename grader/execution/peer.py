"""Which process writes at the other end of a socket, as the system tells."""

from __future__ import annotations

import socket
import struct

_CREDENTIALS = struct.Struct("3i")  # process, user, group


def sender(sock: socket.socket) -> int:
    """Return the number of the process at the other end, once it has written; 0 if unknown."""
    if not hasattr(socket, "SCM_CREDENTIALS"):
        return 0
    room = socket.CMSG_SPACE(_CREDENTIALS.size)
    _, ancillary, _, _ = sock.recvmsg(1, room, socket.MSG_PEEK)
    for level, kind, data in ancillary:
        if (level, kind) == (socket.SOL_SOCKET, socket.SCM_CREDENTIALS):
            return int(_CREDENTIALS.unpack(data[: _CREDENTIALS.size])[0])
    return 0


def ask_for_sender(sock: socket.socket) -> None:
    """Have the system say who writes at the other end; before it does."""
    if hasattr(socket, "SO_PASSCRED"):
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_PASSCRED, 1)
