"""The parent's end of the socket to a worker: telling, asking, and the worker's last words.

What is told is not waited for: that the worker has failed is heard when an answer is due.
"""

from __future__ import annotations

import contextlib
import os
import socket
import threading
import time
from collections.abc import Iterator, Sequence
from typing import IO, Any

from grader.execution.peer import ask_for_sender, sender
from grader.execution.session_report import MAX_TEXT, printable
from grader.execution.session_socket import ANSWER_SECONDS, MachineError
from grader.worker import frames


class ControlSocket:
    """The socket, and the file of the worker's errors. Threads may share it."""

    def __init__(self, sock: socket.socket, errors: IO[bytes]) -> None:
        self._sock, self._errors = sock, errors
        self._busy = threading.Lock()
        self._cut_short = False  # by an exception: what is on the way belongs to nobody
        self._pid: int | None = None
        ask_for_sender(sock)

    def pid(self) -> int:
        """Wait for the worker; return its number as seen from here, 0 if this system hides it.

        Raises MachineError when it does not start.
        """
        with self._busy:
            if self._pid is None:
                try:
                    self._sock.settimeout(ANSWER_SECONDS)
                    pid = sender(self._sock)
                    self._read(0)
                except (OSError, EOFError, ValueError) as error:
                    raise self.failure("it does not start", error) from error
                self._pid = pid
            return self._pid

    def tell(
        self, head: dict[str, Any], payload: bytes = b"", descriptors: Sequence[int] = ()
    ) -> None:
        """Send a request that has no answer. Raises MachineError after one that was cut short."""
        with self._alone():
            self._send(head, payload, descriptors)

    def ask(self, head: dict[str, Any], size: int) -> bytes:
        """Send a request; return its answer, of exactly `size` bytes. Raises MachineError."""
        with self._alone():
            self._send(head)
            try:
                answer = self._read(size)
            except (OSError, EOFError, ValueError) as error:
                raise self.failure(f"it does not answer ({head['do']})", error) from error
        if len(answer) != size:
            raise MachineError(f"the worker's answer to {head['do']} has {len(answer)} bytes")
        return answer

    def failure(self, what: str, error: Exception) -> MachineError:
        """Return the error for a worker that has failed, with the last line that it wrote."""
        said = os.pread(self._errors.fileno(), MAX_TEXT, 0).decode(errors="replace")
        last = printable(said).strip().splitlines()[-1:] or [repr(error)]
        return MachineError(f"the worker failed, {what}: {last[0]}")

    @contextlib.contextmanager
    def _alone(self) -> Iterator[None]:
        with self._busy:
            if self._cut_short:
                raise MachineError("the worker was interrupted: it cannot go on")
            self._cut_short = True
            yield
            self._cut_short = False

    def _send(
        self, head: dict[str, Any], payload: bytes = b"", descriptors: Sequence[int] = ()
    ) -> None:
        data = frames.frame(head, payload)
        with contextlib.suppress(OSError):  # it has gone
            self._sock.settimeout(ANSWER_SECONDS)
            # Descriptors travel with the first bytes.
            sent = socket.send_fds(self._sock, [data], descriptors) if descriptors else 0
            self._sock.sendall(data[sent:])

    def _read(self, size: int) -> bytes:
        deadline = time.monotonic() + ANSWER_SECONDS
        return frames.Reader(self._sock, ahead=0).frame(size, deadline)[1]
