"""What a notebook holds ends when nobody has used it for a while, and starts again when asked."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

SECONDS = 600.0


class Idle:
    """Calls `end` once nothing has been `used` for some time, between two cells.

    The kernel's own loop does it, in the thread of the cells, so that nothing is ended under a call
    that runs. Without a loop, as in a script or in a thread, nothing is ended.
    """

    def __init__(self, end: Callable[[], object]) -> None:
        self._end = end
        self._timer: asyncio.TimerHandle | None = None

    def used(self) -> None:
        """Count the time from here."""
        try:
            loop = asyncio.get_running_loop()
        except RuntimeError:
            return
        if self._timer is not None:
            self._timer.cancel()
        self._timer = loop.call_later(SECONDS, self._end)
