"""From addresses in a library to the function and the line where the code was.

A process in a sandbox has no /proc, and names its calls by addresses only; addr2line, which reads
what the compiler noted in the library, is run here, shut in as well.
"""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from grader.course import exercises
from grader.sandbox.tools import run_tool
from grader.worker import frames

ADDR2LINE_SECONDS = 10
MAX_ADDRESSES = 40
SHIM = "mrt_shim.c"

_REPORTED = re.compile(r"\(([^()\s]+)\+0x([0-9a-f]{1,16})\)")
_PLACE = re.compile(r"(?:.*/)?([\w.]+\.(?:c|h|cpp)):(\d+)")


@dataclass(frozen=True)
class CrashLocation:
    """A function, and "file:line"; both "" when they are not known."""

    function: str = ""
    location: str = ""


NOWHERE = CrashLocation()


def from_page(library: str, page: bytes) -> CrashLocation:
    """Return where the code was when a signal came, as watch.c noted it in the session's page."""
    base, pc, signal, count, *callers = frames.TRACE.unpack_from(page, frames.TRACE_OFFSET)
    if signal == 0:
        return NOWHERE
    # A caller's address is the one to which it will be returned: its line is just before.
    addresses = [pc, *(each - 1 for each in callers[: min(count, frames.FRAMES)])]
    return locate(library, [each - base for each in addresses])


def from_report(library: str, text: str) -> CrashLocation:
    """Return the first place in the library that a sanitizer's report names by its address."""
    name = os.path.basename(library)
    found = [
        int(address, 16) - 1
        for path, address in _REPORTED.findall(text)
        if os.path.basename(path) == name
    ]
    return locate(library, found)


def locate(library: str, offsets: Sequence[int]) -> CrashLocation:
    """Return the first of these places that is in the submission's own code, else in ours."""
    size = Path(library).stat().st_size * 64  # a library's globals are not in its file
    sane = [f"{each:#x}" for each in offsets if 0 < each < size][:MAX_ADDRESSES]
    if not sane:
        return NOWHERE
    command = ["addr2line", "-a", "-C", "-f", "-i", "-s", "-e", library, *sane]
    try:
        ran = run_tool(command, Path(library).parent, [Path(library)], seconds=ADDR2LINE_SECONDS)
    except OSError:
        return NOWHERE  # no addr2line on this machine
    places = [each for each in _places(ran.output) if not each.location.startswith(SHIM)]
    given = exercises.load().given
    own = [each for each in places if each.location.partition(":")[0] not in given]
    return next(iter([*own, *places]), NOWHERE)


def _places(output: str) -> list[CrashLocation]:
    """Return what addr2line found: after each address, pairs of lines, inlined calls first."""
    places = []
    function = ""
    for line in output.splitlines():
        if line.startswith("0x"):
            function = ""
        elif not function:
            function = line
        else:
            if found := _PLACE.match(line):
                places.append(CrashLocation(function, f"{found[1]}:{found[2]}"))
            function = ""
    return places
